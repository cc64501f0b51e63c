// Pixels: out of the page's elements into arrays of 32-bit floats.

/** The values of one plane. Its element is taken out of the page, for it is as large again. */
async function inflatePlane(id, pixels) {
  const element = document.getElementById(id);
  if (!element) throw new Error("the page is damaged: a plane is missing");
  const text = element.textContent;
  element.remove();
  return new Float32Array((await inflate(text, 4 * pixels)).buffer);
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
