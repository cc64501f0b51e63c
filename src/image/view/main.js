// The page: reads its data and images, and puts the parts together.

function say(text, isError = false) {
  const message = element("message");
  message.textContent = text;
  message.hidden = text === "";
  message.classList.toggle("error", isError);
}

/** Names over the images, at their sides, and on the page. */
function showNames(data) {
  const two = data.images.length > 1;
  data.images.forEach((image, index) => {
    image.label = two ? `${"AB"[index]}: ${image.name}` : image.name;
    element(`label-${index}`).textContent = two ? image.label : "";
  });
  element("label-0").hidden = !two;
  element("label-1").hidden = !two;
  element("names").textContent = data.images.map((image) => image.name).join(" | ");
}

/** What the files say about themselves. */
function showMetadata(data) {
  const lists = data.images.map((image) => {
    const facts = [
      ["size", `${image.width} × ${image.height}`],
      ["channels", image.channels.join(", ")],
      ["components", image.components === 4 ? "S0 to S3" : "S0 alone"],
      ["variances", image.variance ? "stored" : "not stored"],
      ...image.metadata,
    ];
    const items = facts.flatMap(([key, value]) => [
      make("dt", { textContent: key }), make("dd", { textContent: value }),
    ]);
    return make("div", {}, make("h3", { textContent: image.label }), make("dl", {}, ...items));
  });
  element("metadata").replaceChildren(...lists);
}

async function loadImages(data) {
  const counts = data.images.map((image) => {
    return image.channels.length * image.components * (image.variance ? 2 : 1);
  });
  const planes = counts.reduce((sum, count) => sum + count, 0);
  let done = 0;
  const progress = () => {
    done += 1;
    say(`Reading pixels: ${Math.round((100 * done) / planes)}%`);
  };
  const images = [];
  for (const [index, about] of data.images.entries()) {
    images.push(await loadImage(about, index, progress));
    if (about.bands) addMixes(images[index]);
  }
  return images;
}

/** Saves the whole of what is shown: the images side by side, one pixel for one. */
function savePicture(images, painterFor, name) {
  const [{ width, height }] = images;
  const canvas = make("canvas", { width: width * images.length, height });
  const context = canvas.getContext("2d");
  const sheet = make("canvas");
  images.forEach((image, index) => {
    const whole = { x: 0, y: 0, columns: width, rows: height, step: 1 };
    paintOnto(sheet, image, painterFor(image), whole);
    context.drawImage(sheet, index * width, 0);
  });
  canvas.toBlob((blob) => {
    if (!blob) {
      say("The browser cannot make a picture of this size.", true);
      return;
    }
    const link = make("a", { href: URL.createObjectURL(blob), download: `${name}.png` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }, "image/png");
}

/** Shows a pixel of all images; a band that is clicked in its spectrum is chosen. */
function showPixel(images, [x, y], { data, state, onPick }) {
  element("place").textContent = `${x}, ${y}`;
  const labeled = (image, ...parts) => {
    if (images.length === 1) return parts;
    return [make("figure", {}, make("figcaption", { textContent: labelOf(image) }), ...parts)];
  };
  const at = (image) => y * image.width + x;
  const blocks = images.flatMap((image) => {
    if (!image.bands) {
      return labeled(image, makeTable(image, at(image), columnsOf(image, data.luminance)));
    }
    const view = { channel: state.channel, ends: data.ends.map(Math.fround), onPick };
    const table = makeTable(image, at(image), bandColumns(image, state.channel));
    return labeled(image, makeSpectrum(image, at(image), view), table);
  });
  element("vectors").replaceChildren(...blocks);
  // Tables of all bands are large, and few look at them.
  const isOpen = element("all-bands").open;
  const tables = images.filter((image) => isOpen && image.bands);
  element("band-values").replaceChildren(
    ...tables.flatMap((image) => labeled(image, makeBandTable(image, at(image)))),
  );
}

function start(data, images) {
  const palette = new Palette(data);
  const hasBands = images.some((image) => image.bands);
  const state = {
    map: data.maps[0], channel: null, end: data.end, exposure: 0, analyzer: "none", angle: 0,
  };
  const painterFor = (image) => painterOf(paintedOf(image, state), {
    map: state.map,
    channel: state.channel,
    end: data.ends[state.end],
    faded: data.degree_faded,
    gain: Math.fround(2 ** state.exposure),
    weights: analyzerWeights(state.analyzer, state.angle),
    luminance: data.luminance,
  }, palette);
  let place = [0, 0];
  let controls = null;
  const onPick = (channel) => controls.set({ channel });
  const showPlace = () => showPixel(images, place, { data, state, onPick });
  const stage = new Stage(images, {
    painterFor,
    onPixel: (pixel) => {
      place = pixel;
      showPlace();
    },
  });
  const changed = () => {
    showLegend(element("legend"), state, data, palette);
    stage.change();
    if (hasBands) showPlace();
  };
  controls = new Controls(data, state, { onChange: changed });
  changed();
  stage.onPixel(stage.size.map((length) => Math.floor(length / 2)));
  element("all-bands").hidden = !hasBands;
  element("all-bands").addEventListener("toggle", showPlace);
  element("zoom-in").addEventListener("click", () => stage.zoomBy(2));
  element("zoom-out").addEventListener("click", () => stage.zoomBy(0.5));
  element("zoom-fit").addEventListener("click", () => stage.fit());
  element("zoom-one").addEventListener("click", () => stage.zoomTo(1));
  const stem = images[0].name.replace(/\.[^.]*$/, "");
  element("save").addEventListener("click", () => {
    savePicture(images, painterFor, `${stem}-${state.map.id}`);
  });
}

async function main() {
  checkBrowser();
  const data = JSON.parse(element("data").textContent);
  showNames(data);
  showMetadata(data);
  const images = await loadImages(data);
  say("");
  start(data, images);
  document.documentElement.dataset.ready = "yes";
}

main().catch((error) => say(`This page cannot be shown: ${error.message}`, true));
