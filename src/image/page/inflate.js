// What is packed in a page: out of base64 and deflate, into bytes.

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
  return bytes;
}

/** So many bytes that a text holds. */
async function inflate(text, length) {
  const stream = new DecompressionStream("deflate");
  const [, bytes] = await Promise.all([
    write(text, stream.writable),
    read(stream.readable, length),
  ]);
  return bytes;
}

/** Whether the browser knows how. */
function checkBrowser() {
  if (typeof DecompressionStream === "undefined") {
    throw new Error("this browser is too old: it cannot inflate (Chromium 104, Firefox 113 and "
      + "Safari 16.4 can)");
  }
}
