// Maps: small copies of images out of the page, and their colors.

/** Shares of white that light has where its code is 0 and its polarization is known. */
const FAINT = 1e-4;

/** The images that a small copy is: S0 by channel, and the Stokes vectors of luminance, if any. */
async function loadThumbnail(job, at, palette, luminance) {
  const { thumbnail: { width, height, white }, channels, components } = job.image;
  const source = element(`pixels-${at}`);
  const pixels = width * height;
  const planes = channels.length + (components === 4 ? 3 : 0);
  const codes = await inflate(source.textContent, pixels * planes);
  const plane = (index) => codes.subarray(index * pixels, (index + 1) * pixels);
  const { linear } = palette.tables;
  const s0 = channels.map((_, index) => Float32Array.from(plane(index), (code) => white * linear[code]));
  const intensity = { width, height, channels, components: 1, values: [s0] };
  if (components !== 4) return { intensity, light: intensity };
  const [red, green, blue] = s0;
  const whole = green
    ? (pixel) => times(luminance, red[pixel], green[pixel], blue[pixel]) : (pixel) => red[pixel];
  const [degree, angle, ellipticity] = [0, 1, 2].map((index) => plane(channels.length + index));
  const values = [0, 1, 2, 3].map(() => [new Float32Array(pixels)]);
  for (let pixel = 0; pixel < pixels; pixel += 1) {
    // The code of no light.
    if (ellipticity[pixel] === 255) continue;
    const brightness = Math.max(whole(pixel), FAINT * white);
    const polarized = brightness * (degree[pixel] / 255) ** 2;
    const twice = (((ellipticity[pixel] - 127) / 127) * Math.PI) / 2;
    const turn = (2 * Math.PI * angle[pixel]) / 256;
    values[0][0][pixel] = brightness;
    values[1][0][pixel] = polarized * Math.cos(twice) * Math.cos(turn);
    values[2][0][pixel] = polarized * Math.cos(twice) * Math.sin(turn);
    values[3][0][pixel] = polarized * Math.sin(twice);
  }
  return { intensity, light: { width, height, channels: ["luminance"], components: 4, values } };
}

/** The maps that are shown of every image, their choices and their legends. */
class Maps {
  constructor(data, state, palette, { onChange }) {
    Object.assign(this, { data, state, palette, onChange, thumbnails: new Map() });
    const wanted = ["intensity", "dop", "aolp"].map((id) => data.maps.find((map) => map.id === id));
    state.maps = wanted.filter((map) => map);
    this.columns = state.maps.map((_, place) => this.makeColumn(place));
    element("maps").append(...this.columns.map(({ box }) => box));
    element("maps").hidden = false;
    this.show();
  }

  makeColumn(place) {
    const select = make("select");
    select.setAttribute("aria-label", `Map ${place + 1}`);
    const groups = new Map();
    for (const map of this.data.maps) {
      if (!groups.has(map.group)) groups.set(map.group, make("optgroup", { label: map.group }));
      groups.get(map.group).append(make("option", { value: map.id, textContent: map.title }));
    }
    select.append(...groups.values());
    select.value = this.state.maps[place].id;
    select.addEventListener("change", () => {
      this.state.maps[place] = this.data.maps.find((map) => map.id === select.value);
      this.onChange();
    });
    const legend = make("div", { className: "legend" });
    return { box: make("div", { className: "column" }, select, legend), legend };
  }

  /** The legends, and which choices there are. */
  show() {
    const { state, data, palette } = this;
    this.columns.forEach(({ legend }, place) => {
      showLegend(legend, { ...state, map: state.maps[place], analyzer: "none" }, data, palette);
    });
    element("end-row").hidden = state.maps.every((map) => map.legends.length < 2);
    element("exposure-row").hidden = state.maps.every((map) => map.quantity !== "intensity");
  }

  /** The small copy of a job's image, read once. */
  thumbnail(job) {
    const { thumbnails, palette, data } = this;
    const at = data.jobs.indexOf(job);
    if (!thumbnails.has(at)) {
      thumbnails.set(at, loadThumbnail(job, at, palette, data.luminance));
    }
    return thumbnails.get(at);
  }

  /** Paints the maps of a job onto canvases. */
  async paint(job, canvases) {
    const { state, data, palette } = this;
    const { intensity, light } = await this.thumbnail(job);
    canvases.forEach((canvas, place) => {
      const map = state.maps[place];
      const image = map.quantity === "intensity" ? intensity : light;
      const painter = painterOf(image, {
        map,
        channel: state.channel,
        end: data.ends[state.end],
        faded: data.degree_faded,
        gain: Math.fround(2 ** state.exposure),
        weights: analyzerWeights("none", 0),
        luminance: data.luminance,
      }, palette);
      paintOnto(canvas, image, painter, {
        x: 0, y: 0, columns: image.width, rows: image.height, step: 1,
      });
      canvas.title = map.title;
    });
  }
}
