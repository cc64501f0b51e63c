// The readout: Stokes vector, degrees, angles and the ellipse of a pixel, or of the mean of an image.

/** The column of a channel. */
function channelColumn(image, channel, kind) {
  return {
    name: image.channels[channel],
    kind,
    stokes: (pixel) => image.values.map((planes) => planes[channel][pixel]),
    errors: (pixel) => image.variances?.map((planes) => Math.sqrt(planes[channel][pixel])),
  };
}

/** The columns of the table: channels, and with red, green and blue their luminance. */
function columnsOf(image, luminance) {
  const kind = (name) => (image.channels.length === 3 ? name.toLowerCase() : "mono");
  const channels = image.channels.map((name, at) => channelColumn(image, at, kind(name)));
  if (channels.length === 1) return channels;
  const read = isPolarized(image) ? stokesReader(image, null, luminance) : null;
  const of = (pixel) => {
    const stokes = new Array(4);
    read(pixel, stokes);
    return stokes;
  };
  const all = { name: "Lum.", kind: "luminance", stokes: of, errors: () => undefined };
  return read ? [...channels, all] : channels;
}

/** A row of the table: a name, and a cell for every column. */
function makeRow(name, title, cells) {
  const head = make("th", { scope: "row", textContent: name, title });
  return make("tr", {}, head, ...cells);
}

function valueCell(value, error) {
  const exact = Object.is(value, -0) ? "-0" : String(value);
  const cell = make("td", { textContent: shortNumber(value), title: exact });
  cell.dataset.value = exact;
  if (error !== undefined) {
    const text = `± ${shortNumber(error)}`;
    cell.append(make("small", { textContent: text, title: `standard error ${error}` }));
  }
  return cell;
}

/**
 * Rows of what follows from a Stokes vector: name, explanation, which figure it is, its text, and
 * the degree without which there is none.
 */
const FIGURES = [
  ["DoP", "Degree of polarization", "dop", percent, null],
  ["DoLP", "Degree of linear polarization", "dolp", percent, null],
  ["AoLP", "Angle of linear polarization", "aolp", degrees, "dolp"],
  ["Ellip.", "Ellipticity angle: above 0 right, below left", "ellipticity", degrees, "dop"],
];

/** The cell of a figure of light, if there is light and it has that figure. */
function figureCell(light, figure, words, needed) {
  if (!light || (needed && !(light[needed] > 0))) return make("td", { textContent: "–" });
  const cell = make("td", { textContent: words(light[figure]) });
  cell.dataset.value = String(light[figure]);
  return cell;
}

/** The table of one image at a pixel. */
function makeTable(image, pixel, columns) {
  const vectors = columns.map((column) => column.stokes(pixel));
  const errors = columns.map((column) => column.errors(pixel));
  const heads = columns.map(({ name, kind }) => {
    return make("th", { scope: "col", textContent: name, className: kind });
  });
  const rows = [make("tr", {}, make("td"), ...heads)];
  for (let component = 0; component < image.components; component += 1) {
    const cells = vectors.map((stokes, i) => valueCell(stokes[component], errors[i]?.[component]));
    rows.push(makeRow(`S${component}`, "", cells));
  }
  if (isPolarized(image)) {
    const lights = vectors.map((stokes) => (isLit(stokes) ? polarizationOf(stokes) : null));
    for (const [name, title, ...figure] of FIGURES) {
      rows.push(makeRow(name, title, lights.map((light) => figureCell(light, ...figure))));
    }
    const ellipses = lights.map((light, i) => make("td", {}, makeEllipse(light, columns[i].kind)));
    rows.push(makeRow("Field", "What the field draws, as one looks at the image", ellipses));
  }
  return make("table", {}, ...rows);
}

/**
 * The ellipse that the field's end draws, as one looks at the image: the shape of the polarized
 * part, in a circle whose filled share is the degree of polarization.
 */
function makeEllipse(light, kind) {
  const picture = svg("svg", { viewBox: "-24 -24 48 48", class: `ellipse ${kind}`, role: "img" });
  const title = light ? ellipseWords(light) : "no light";
  picture.append(svg("title", {}, title), svg("circle", { r: 22, class: "whole" }));
  if (!light) return picture;
  const around = 2 * Math.PI * 22;
  const filled = around * Math.min(1, light.dop);
  picture.append(svg("circle", {
    r: 22, class: "degree", transform: "rotate(-90)", "stroke-dasharray": `${filled} ${around}`,
  }));
  if (!(light.dop > 0)) return picture;
  const [major, minor] = [17 * Math.cos(light.ellipticity), 17 * Math.sin(light.ellipticity)];
  // Down is positive on the screen, hence the sign of the turn.
  const turn = (-light.aolp * 180) / Math.PI;
  const shape = svg("g", { transform: `rotate(${turn})` });
  // An ellipse without any width would not be drawn.
  const width = Math.max(Math.abs(minor), 0.05);
  shape.append(svg("ellipse", { rx: major, ry: width, class: "field" }));
  if (Math.abs(minor) > 1) shape.append(arrowAt(major, minor));
  picture.append(shape);
  return picture;
}

/** An arrow at the end of the long axis: down, clockwise, for what is right circular. */
function arrowAt(major, minor) {
  const way = minor > 0 ? 1 : -1;
  return svg("path", {
    d: `M ${major - 3.5} ${-2 * way} L ${major} ${2.5 * way} L ${major + 3.5} ${-2 * way}`,
    class: "arrow",
  });
}

function ellipseWords(light) {
  const angle = light.ellipticity;
  if (!(light.dop > 0)) return "unpolarized";
  const hand = angle > 0 ? "right" : "left";
  return Math.abs(angle) < 1e-6
    ? `linear at ${degrees(light.aolp)}`
    : `${hand} handed, axis at ${degrees(light.aolp)}`;
}
