// Bands: what is seen of them all, and the spectrum of a pixel.

/** The room of a plot of a spectrum, in its own units: width, left margin, and heights. */
const PLOT = { width: 326, left: 4, right: 4, s0: 84, signed: 96, degree: 62, gap: 16, axis: 18 };
/** Bands whose errors are drawn, at most: of more they would be a blot. */
const ERRORS_MAX = 100;

/** The sum of planes times weights. */
function mixed(planes, weights) {
  const sum = new Float32Array(planes[0].length);
  planes.forEach((plane, band) => {
    const weight = weights[band];
    for (let pixel = 0; pixel < sum.length; pixel += 1) sum[pixel] += weight * plane[pixel];
  });
  return sum;
}

/**
 * Adds to an image of bands what is shown of all of them together: `mean`, an image of one channel,
 * and `seen`, one of red, green and blue, or the mean where bands do not tell these.
 */
function addMixes(image) {
  const { width, height, components, bands } = image;
  const of = (channels, weights) => ({
    width, height, components, channels,
    values: image.values.map((planes) => weights.map((list) => mixed(planes, list))),
  });
  image.mean = of(["mean"], [bands.map(() => 1 / bands.length)]);
  const { weights } = image;
  image.seen = weights
    ? of(["R", "G", "B"], [0, 1, 2].map((color) => weights.map((weight) => weight[color])))
    : image.mean;
}

/** The image whose channels are painted: that of all bands together if none is chosen. */
function paintedOf(image, { channel, map }) {
  if (!image.bands || channel !== null) return image;
  return map.quantity === "intensity" ? image.seen : image.mean;
}

/** A band in words: its center and its width. */
function bandWords({ center_nm: center, width_nm: width }) {
  return `${threeOrMore(center)} nm, ${threeDigits(width)} nm wide`;
}

/** A wavelength without needless digits. */
const threeOrMore = (nm) => String(Number(nm.toPrecision(7)));

/** What a band is called in a list: by its name, and its center if the name does not say it. */
function bandName(image, index) {
  const [name, center] = [image.channels[index], threeOrMore(image.bands[index].center_nm)];
  return name.includes(center) ? name : `${name} (${center} nm)`;
}

/** The columns of the table of a pixel: the band that is chosen, and the mean of all. */
function bandColumns(image, channel) {
  const all = {
    name: "Mean", kind: "luminance", errors: () => undefined,
    stokes: (pixel) => image.mean.values.map(([plane]) => plane[pixel]),
  };
  return channel === null ? [all] : [channelColumn(image, channel, "mono"), all];
}

/** The Stokes vectors of a pixel by band, and their standard errors if there are any. */
function spectrumOf(image, pixel) {
  return image.bands.map((band, index) => ({
    center: band.center_nm,
    low: band.center_nm - band.width_nm / 2,
    high: band.center_nm + band.width_nm / 2,
    stokes: image.values.map((planes) => planes[index][pixel]),
    errors: image.variances?.map((planes) => Math.sqrt(planes[index][pixel])),
  }));
}

/** The largest of finite sizes, or 1 if there is none above zero. */
function largest(values) {
  return values.filter(Number.isFinite).reduce((most, value) => Math.max(most, Math.abs(value)), 0)
    || 1;
}

/** A curve over the bands: a bar as wide as each, and a line through their centers. */
function makeCurve(spectrum, { x, y, kind, value, error }) {
  const points = spectrum.map((band) => ({ ...band, value: value(band), error: error?.(band) }));
  const finite = points.filter((point) => Number.isFinite(point.value));
  const bars = finite.map(({ low, high, value }) => `M${x(low)} ${y(value)}H${x(high)}`);
  const line = points.map(({ center, value }, index) => {
    if (!Number.isFinite(value)) return "";
    const joins = index > 0 && Number.isFinite(points[index - 1].value);
    return `${joins ? "L" : "M"}${x(center)} ${y(value)}`;
  });
  const curve = svg("g", { class: `curve ${kind}` },
    svg("path", { class: "line", d: line.join("") }),
    svg("path", { class: "bars", d: bars.join("") }));
  if (error && points.length <= ERRORS_MAX) {
    const errors = finite.filter((point) => point.error > 0 && Number.isFinite(point.error));
    const spans = errors.map(({ center, value, error }) => {
      return `M${x(center)} ${y(value - error)}V${y(value + error)}`;
    });
    curve.append(svg("path", { class: "errors", d: spans.join("") }));
  }
  return curve;
}

/** A panel of a plot: its frame, the ends of its scale and its curves. */
function makePanel(plot, { top, height, ends: [low, high], title, words, curves }) {
  const y = (value) => {
    const share = Math.max(-0.02, Math.min(1.02, (value - low) / (high - low)));
    return (top + height * (1 - share)).toFixed(2);
  };
  const { left, right } = plot;
  const panel = svg("g", { class: "panel", "data-top": top, "data-height": height,
    "data-low": low, "data-high": high });
  const rule = (value) => svg("path", { class: "rule", d: `M${left} ${y(value)}H${right}` });
  panel.append(rule(low), rule(high));
  if (low < 0 && high > 0) panel.append(rule(0));
  panel.append(...curves.map((curve) => makeCurve(plot.spectrum, { x: plot.x, y, ...curve })));
  const text = (at, words, end) => svg("text", { x: end ? right : left, y: at,
    "text-anchor": end ? "end" : "start" }, ...words);
  panel.append(text(top - 4, title, false), text(top - 4, [words(high)], true));
  if (low < 0) panel.append(text(top + height - 3, [words(low)], true));
  return panel;
}

/** Wavelengths to mark on an axis: round ones, a handful. */
function roundWavelengths(from, to) {
  const powers = [0.1, 1, 10, 100, 1000, 1e4, 1e5];
  const steps = [1, 2, 5].flatMap((step) => powers.map((by) => step * by));
  const step = steps.sort((a, b) => a - b).find((size) => (to - from) / size <= 6) ?? to - from;
  const marks = [];
  for (let mark = Math.ceil(from / step) * step; mark <= to; mark += step) marks.push(mark);
  return marks;
}

/** A number at the end of a scale. */
const plotNumber = (value) => minus(threeDigits(value));

/** The panels of a plot: S0, then S1 to S3 and the degree of polarization if there are any. */
function panelsOf(image, spectrum, ends) {
  const of = (component, kind) => ({
    kind, value: ({ stokes }) => stokes[component],
    error: image.variances && (({ errors }) => errors[component]),
  });
  const all = (component) => spectrum.map(({ stokes }) => stokes[component]);
  const least = Math.min(0, ...all(0).filter(Number.isFinite));
  const s0 = {
    height: PLOT.s0, ends: [least, largest(all(0))], title: ["S0"], words: plotNumber,
    curves: [of(0, "s0")],
  };
  if (!isPolarized(image)) return [s0];
  const most = largest([1, 2, 3].flatMap(all));
  const names = [1, 2, 3].map((component) => {
    return svg("tspan", { class: `s${component}` }, `S${component} `);
  });
  const degree = ({ stokes }) => (isLit(stokes) ? polarizationOf(stokes).dop : NaN);
  const largestDegree = largest(spectrum.map(degree));
  const end = ends.find((end) => largestDegree <= end) ?? 1;
  return [
    s0,
    { height: PLOT.signed, ends: [-most, most], title: names, words: plotNumber,
      curves: [1, 2, 3].map((component) => of(component, `s${component}`)) },
    { height: PLOT.degree, ends: [0, end], title: ["Degree of polarization"],
      words: (share) => percent(share), curves: [{ kind: "dop", value: degree }] },
  ];
}

/** The spectrum of a pixel as a plot; a click in it picks the nearest band. */
function makeSpectrum(image, pixel, { channel, ends, onPick }) {
  const spectrum = spectrumOf(image, pixel);
  const [from, to] = [spectrum[0].low, spectrum[spectrum.length - 1].high];
  const [left, right] = [PLOT.left, PLOT.width - PLOT.right];
  const x = (nm) => (left + ((right - left) * (nm - from)) / (to - from)).toFixed(2);
  const plot = { spectrum, x, left, right };
  const picture = svg("svg", { class: "spectrum", role: "img", "data-from": from, "data-to": to });
  const chosen = channel === null ? "" : `, ${bandWords(image.bands[channel])} chosen`;
  const range = `from ${threeOrMore(from)} to ${threeOrMore(to)} nm`;
  picture.append(svg("title", {}, `Spectrum ${range}${chosen}`));
  let top = PLOT.gap;
  for (const panel of panelsOf(image, spectrum, ends)) {
    picture.append(makePanel(plot, { top, ...panel }));
    top += panel.height + PLOT.gap;
  }
  const bottom = top - PLOT.gap;
  for (const nm of roundWavelengths(from, to)) {
    const at = Number(x(nm));
    const anchor = at < left + 14 ? "start" : at > right - 14 ? "end" : "middle";
    picture.append(svg("path", { class: "rule", d: `M${at} ${bottom}v4` }),
      svg("text", { x: at, y: bottom + 15, "text-anchor": anchor }, threeOrMore(nm)));
  }
  if (channel !== null) {
    const at = x(spectrum[channel].center);
    picture.append(svg("path", { class: "chosen", d: `M${at} ${PLOT.gap}V${bottom}` }));
  }
  picture.setAttribute("viewBox", `0 0 ${PLOT.width} ${bottom + PLOT.axis}`);
  picture.addEventListener("click", (event) => {
    const box = picture.getBoundingClientRect();
    const unit = ((event.clientX - box.left) / box.width) * PLOT.width;
    const nm = from + ((unit - left) / (right - left)) * (to - from);
    const distance = (band) => Math.abs(band.center - nm);
    const nearest = spectrum.reduce((best, band, index) => {
      return distance(band) < distance(spectrum[best]) ? index : best;
    }, 0);
    onPick(nearest);
  });
  return picture;
}

/** All values of a pixel, a row a band. */
function makeBandTable(image, pixel) {
  const names = ["S0", "S1", "S2", "S3"].slice(0, image.components);
  const heads = isPolarized(image) ? [...names, "DoP"] : names;
  const head = make("tr", {}, make("td", { textContent: "nm" }),
    ...heads.map((name) => make("th", { scope: "col", textContent: name })));
  const rows = spectrumOf(image, pixel).map(({ center, stokes, errors }, index) => {
    const cells = stokes.map((value, component) => valueCell(value, errors?.[component]));
    if (isPolarized(image)) {
      const light = isLit(stokes) ? polarizationOf(stokes) : null;
      cells.push(figureCell(light, "dop", percent, null));
    }
    return makeRow(threeOrMore(center), bandWords(image.bands[index]), cells);
  });
  return make("table", { className: "bands" }, head, ...rows);
}
