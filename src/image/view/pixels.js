// Pixels: out of the page's elements, base64 and deflate, into arrays of 32-bit floats.

/** Characters of base64 that are decoded at once; a multiple of four. */
const PIECE = 1 << 20;

/** The bytes of a piece of base64. */
function bytesOf(base64) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(base64);
  return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
}

async function write(text, writable) {
  const writer = writable.getWriter();
  for (let start = 0; start < text.length; start += PIECE) {
    await writer.write(bytesOf(text.slice(start, start + PIECE)));
  }
  await writer.close();
}

async function read(readable, length) {
  const bytes = new Uint8Array(length);
  const reader = readable.getReader();
  let filled = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    if (filled + value.length > length) throw new Error("the page is damaged: too many pixels");
    bytes.set(value, filled);
    filled += value.length;
  }
  if (filled !== length) throw new Error("the page is damaged: pixels are missing");
  return new Float32Array(bytes.buffer);
}

/** The values of one plane. Its element is taken out of the page, for it is as large again. */
async function inflatePlane(id, pixels) {
  const element = document.getElementById(id);
  if (!element) throw new Error("the page is damaged: a plane is missing");
  const text = element.textContent;
  element.remove();
  const stream = new DecompressionStream("deflate");
  const [, plane] = await Promise.all([
    write(text, stream.writable),
    read(stream.readable, 4 * pixels),
  ]);
  return plane;
}

/**
 * An image with its planes: `values[component][channel]`, and `variances` alike if it has any.
 * `progress` is told after every plane.
 */
async function loadImage(about, index, progress) {
  const pixels = about.width * about.height;
  const channels = about.channels.length;
  const kinds = about.variance ? ["values", "variances"] : ["values"];
  const image = { ...about, index, values: null, variances: null };
  for (const kind of kinds) {
    image[kind] = [];
    for (let component = 0; component < about.components; component += 1) {
      const planes = [];
      for (let channel = 0; channel < channels; channel += 1) {
        const id = `pixels-${index}-${kind}-${component * channels + channel}`;
        planes.push(await inflatePlane(id, pixels));
        progress();
      }
      image[kind].push(planes);
    }
  }
  return image;
}
