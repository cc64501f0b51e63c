// Legends: what the colors of a map mean, as under the pictures of `sunstone visualize`.

/** What an analyzer is called. */
function analyzerWords({ analyzer, angle }) {
  switch (analyzer) {
    case "linear": return `behind a linear analyzer at ${angle}°`;
    case "right": return "behind a right circular analyzer";
    case "left": return "behind a left circular analyzer";
    default: return "";
  }
}

/** The legend of what is shown: title, ticks, swatches and whether there is a disk. */
function legendOf(state, data) {
  const { map } = state;
  if (map.quantity !== "intensity") return map.legends[state.end] ?? map.legends[0];
  const end = 2 ** -state.exposure;
  const ticks = data.intensity_ticks.map(([place, share]) => [place, threeDigits(share * end)]);
  const title = state.analyzer === "none"
    ? map.legends[0].title
    : `intensity ${analyzerWords(state)}`;
  return { ...map.legends[0], title, ticks };
}

/** A bar with one column of pixels for every color of the scale. */
function makeBar(palette, scale) {
  const colors = palette.scales[scale];
  const count = colors.length / 3;
  const canvas = make("canvas", { width: count, height: 1, className: "bar" });
  const context = canvas.getContext("2d");
  const picture = context.createImageData(count, 1);
  for (let i = 0; i < count; i += 1) {
    picture.data.set([colors[3 * i], colors[3 * i + 1], colors[3 * i + 2], 255], 4 * i);
  }
  context.putImageData(picture, 0, 0);
  return canvas;
}

/** A disk whose every point has the color of its direction. */
function makeDisk(palette, scale) {
  const side = 128;
  const canvas = make("canvas", { width: side, height: side, className: "disk" });
  const context = canvas.getContext("2d");
  const picture = context.createImageData(side, side);
  const color = new Uint8Array(3);
  for (let y = 0; y < side; y += 1) {
    for (let x = 0; x < side; x += 1) {
      const [dx, dy] = [x + 0.5 - side / 2, side / 2 - y - 0.5];
      const distance = Math.hypot(dx, dy) / (side / 2);
      if (distance < 0.3 || distance > 1) continue;
      const turn = Math.atan2(dy, dx) / Math.PI;
      palette.sample(scale, turn < 0 ? turn + 1 : turn, color);
      picture.data.set([...color, 255], 4 * (y * side + x));
    }
  }
  context.putImageData(picture, 0, 0);
  return canvas;
}

/** Draws the legend of what is shown into an element. */
function showLegend(element, state, data, palette) {
  const { title, ticks, swatches, disk } = legendOf(state, data);
  const { scale } = state.map;
  const marks = ticks.map(([place, label]) => {
    const mark = make("span", { className: "tick", textContent: label });
    mark.style.left = `${100 * place}%`;
    // At the ends labels stand inward.
    mark.style.translate = `${-100 * place}%`;
    mark.style.setProperty("--place", `${100 * place}%`);
    return mark;
  });
  const names = swatches.map(([color, name]) => {
    const swatch = make("i");
    swatch.style.background = css(color);
    return make("span", { className: "swatch" }, swatch, name);
  });
  const body = make(
    "div", { className: "strip" },
    make("div", { className: "legend-title" },
      make("span", { className: "legend-name", textContent: title }), ...names),
    makeBar(palette, scale),
    make("div", { className: "ticks" }, ...marks),
  );
  element.replaceChildren(...(disk ? [makeDisk(palette, scale)] : []), body);
}
