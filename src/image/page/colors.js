// Colors: from values to sRGB codes, by the tables that the page's data hold.

/** A row of a matrix times a column. */
const times = (row, x, y, z) => row[0] * x + row[1] * y + row[2] * z;

/** The palettes of `sunstone visualize`. */
class Palette {
  constructor(data) {
    this.tables = data.palette;
    this.scales = data.scales.map(bytesOf);
    this.last = this.scales[0].length / 3 - 1;
    this.float = new Float32Array(1);
    this.bits = new Uint32Array(this.float.buffer);
    this.firstCodes = this.firstCodesOf(data.palette.thresholds);
    this.lab = new Float64Array(3);
    this.grey = this.toOklab(data.palette.neutral, new Float64Array(3));
    this.dark = this.toOklab(data.palette.no_light, new Float64Array(3));
  }

  /** The code of the smallest value of every 1/128 of an octave, by the upper half of its bits. */
  firstCodesOf(thresholds) {
    const codes = new Uint8Array(1 << 15);
    let code = 0;
    for (let upper = 0; upper < codes.length; upper += 1) {
      this.bits[0] = upper << 16;
      while (code < 255 && this.float[0] >= thresholds[code]) code += 1;
      codes[upper] = code;
    }
    return codes;
  }

  /** A linear value as an sRGB code, clipped; what is not a number is 0. */
  encode(value) {
    if (!(value > 0)) return 0;
    this.float[0] = value;
    let code = this.firstCodes[this.bits[0] >>> 16];
    while (code < 255 && this.float[0] >= this.tables.thresholds[code]) code += 1;
    return code;
  }

  /** The color at a place of a scale, into `color`. */
  sample(scale, place, color) {
    const position = (place > 0 ? Math.min(place, 1) : 0) * this.last;
    const before = Math.min(Math.floor(position), this.last - 1);
    const codes = this.scales[scale];
    for (let i = 3 * before, k = 0; k < 3; i += 1, k += 1) {
      color[k] = Math.round(codes[i] + (position - before) * (codes[i + 3] - codes[i]));
    }
  }

  /** The Oklab color of sRGB codes, into `lab`. */
  toOklab(color, lab) {
    const { linear, cones_of_rgb: cones, lab_of_roots: rows } = this.tables;
    const [r, g, b] = [linear[color[0]], linear[color[1]], linear[color[2]]];
    const long = Math.cbrt(times(cones[0], r, g, b));
    const medium = Math.cbrt(times(cones[1], r, g, b));
    const short = Math.cbrt(times(cones[2], r, g, b));
    for (let i = 0; i < 3; i += 1) lab[i] = times(rows[i], long, medium, short);
    return lab;
  }

  /** Mixes `color` with a ground in Oklab, of which it replaces a share; even to the eye. */
  mixInto(color, ground, share) {
    const { roots_of_lab: rows, rgb_of_cones: rgb } = this.tables;
    const lab = this.toOklab(color, this.lab);
    for (let i = 0; i < 3; i += 1) lab[i] = ground[i] + share * (lab[i] - ground[i]);
    const [l, a, b] = lab;
    const long = times(rows[0], l, a, b) ** 3;
    const medium = times(rows[1], l, a, b) ** 3;
    const short = times(rows[2], l, a, b) ** 3;
    for (let i = 0; i < 3; i += 1) color[i] = this.encode(times(rgb[i], long, medium, short));
  }

  /** Lets a color fade as its map does where the polarization is weak. */
  fade(color, weakness, strength) {
    if (weakness === "grey" && strength < 1) this.mixInto(color, this.grey, strength);
    if (weakness === "dark" && strength < 1) this.mixInto(color, this.dark, strength);
    if (weakness === "dark-hsv") {
      for (let i = 0; i < 3; i += 1) color[i] = Math.round(color[i] * strength);
    }
  }
}

/** A share on a scale from -end to end, clipped to [-1, 1]. */
const scaled = (share, end) => Math.max(-1, Math.min(1, share / end));

/** Where a map puts a Stokes vector on its scale, and how strong the color is: [place, strength]. */
function placeOf(map, stokes, { end, faded }) {
  const light = polarizationOf(stokes);
  const strength = (degree) => Math.min(1, degree / faded);
  const turn = light.aolp / Math.PI;
  switch (map.quantity) {
    case "stokes": return [0.5 + (0.5 * stokes[map.component]) / map.range, 1];
    case "stokes-relative":
      return [0.5 + (0.5 * stokes[map.component]) / (end * stokes[0]), 1];
    case "dop":
    case "dop-red": return [scaled(light.dop, end), 1];
    case "linear-circular": return [light.linearShare, strength(light.dop)];
    case "type": return [light.linearShare, scaled(light.dop, end)];
    case "aolp": return [turn, strength(light.dolp)];
    case "aolp-dark":
    case "orientation": return [turn, scaled(light.dolp, end)];
    case "chirality": return [0.5 + 0.5 * scaled(light.circular, end), 1];
    case "ellipticity":
      return [0.5 + (2 * light.ellipticity) / Math.PI, strength(light.dop)];
    default: throw new Error(`no map ${map.quantity}`);
  }
}

/**
 * What colors the pixels of an image: a function of a pixel that fills the array it is given.
 * `view` says what is shown: map, channel, end, faded, gain, weights, luminance.
 */
function painterOf(image, view, palette) {
  if (view.map.quantity === "intensity") return intensityPainter(image, view, palette);
  return isPolarized(image) ? mapPainter(image, view, palette) : blankPainter(palette);
}

function intensityPainter(image, { channel, gain, weights }, palette) {
  if (!isPolarized(image) && weights[0] !== 1) return blankPainter(palette);
  const channels = channel === null && image.channels.length === 3 ? [0, 1, 2] : [channel ?? 0];
  const readers = channels.map((index) => analyzedReader(image, index, weights));
  const [first, second = first, third = first] = readers;
  const code = (value) => palette.encode(Math.fround(value * gain));
  if (readers.length === 1) return (pixel, color) => { color.fill(code(first(pixel))); };
  return (pixel, color) => {
    color[0] = code(first(pixel));
    color[1] = code(second(pixel));
    color[2] = code(third(pixel));
  };
}

function mapPainter(image, view, palette) {
  const readStokes = stokesReader(image, view.channel, view.luminance);
  const stokes = new Float64Array(4);
  const { scale, weakness } = view.map;
  return (pixel, color) => {
    readStokes(pixel, stokes);
    if (!isLit(stokes)) {
      color.set(palette.tables.no_light);
      return;
    }
    const [place, strength] = placeOf(view.map, stokes, view);
    palette.sample(scale, place, color);
    palette.fade(color, weakness, strength);
  };
}

/** An image without polarization, where polarization is shown. */
function blankPainter(palette) {
  return (_, color) => { color.set(palette.tables.neutral); };
}

/** Paints a region of an image onto a canvas, of every block of `step` pixels one. */
function paintOnto(canvas, image, paint, { x, y, columns, rows, step }) {
  canvas.width = columns;
  canvas.height = rows;
  const context = canvas.getContext("2d");
  const picture = context.createImageData(columns, rows);
  const { data } = picture;
  const color = new Uint8Array(3);
  const middle = step >> 1;
  for (let row = 0, at = 0; row < rows; row += 1) {
    const line = Math.min(y + row * step + middle, image.height - 1) * image.width;
    for (let column = 0; column < columns; column += 1, at += 4) {
      paint(line + Math.min(x + column * step + middle, image.width - 1), color);
      data[at] = color[0];
      data[at + 1] = color[1];
      data[at + 2] = color[2];
      data[at + 3] = 255;
    }
  }
  context.putImageData(picture, 0, 0);
}
