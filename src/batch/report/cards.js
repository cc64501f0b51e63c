// Cards: a job each, and all of one in a dialog.

/** Cards that are made at once. */
const CARDS = 120;

/** The figures that stand on a card. */
const ON_CARDS = [["s0", "S0"], ["dop", "DoP"], ["aolp", "AoLP"]];

/** What the values of a sweep are for a job. */
function makeValues(job) {
  const values = Object.entries(job.values).map(([name, value]) => {
    return make("span", {}, `${name} `, make("b", { textContent: valueWords(value) }));
  });
  return make("p", { className: "values" }, ...values);
}

/** What is wrong with a job. */
function makeTroubles(job) {
  const troubles = [];
  const add = (className, text) => troubles.push(make("p", { className, textContent: text }));
  if (job.error !== null) add("trouble", job.error);
  if (job.former) add("trouble mild", "The image under its name is of a former run.");
  if (job.problem !== null) add("trouble", job.problem);
  if (job.changed) add("trouble", "The image is not the one that was rendered: its checksum differs.");
  const bad = job.image?.not_finite ?? 0;
  if (bad > 0) add("trouble mild", `${bad} pixels are not finite; means are without them.`);
  return troubles;
}

function makeLink(job) {
  if (job.link === null) return make("span", { textContent: job.output });
  return make("a", { href: job.link, textContent: job.output });
}

/** The cards of the jobs that are shown, made as one comes near them. */
class Cards {
  constructor(data, state, { maps, figures, meanFor }) {
    Object.assign(this, { data, state, maps, figures, meanFor, jobs: [], made: 0 });
    this.list = element("cards");
    this.dialog = element("details");
    this.near = new IntersectionObserver((entries) => {
      for (const { isIntersecting, target } of entries) {
        if (!isIntersecting) continue;
        this.near.unobserve(target);
        this.paint(target);
      }
    }, { rootMargin: "400px" });
    this.end = new IntersectionObserver(([{ isIntersecting }]) => {
      if (isIntersecting) this.makeMore();
    }, { rootMargin: "1200px" });
    this.end.observe(element("more"));
    this.list.addEventListener("click", (event) => {
      const card = event.target.closest(".card");
      if (card && event.target.closest("button, canvas")) this.open(data.jobs[card.dataset.job]);
    });
    this.bindDialog();
  }

  show(jobs) {
    this.jobs = jobs;
    this.made = 0;
    this.near.disconnect();
    this.list.replaceChildren();
    this.makeMore();
  }

  /** Paints anew what is on the screen, and the rest when it comes near. */
  repaint() {
    this.near.disconnect();
    for (const card of this.list.children) this.near.observe(card);
    if (this.dialog.open) this.paint(this.dialog);
  }

  makeMore() {
    const next = this.jobs.slice(this.made, this.made + CARDS);
    this.made += next.length;
    const cards = next.map((job) => this.makeCard(job));
    this.list.append(...cards);
    for (const card of cards) this.near.observe(card);
    // The end may still be near, which is told once.
    this.end.unobserve(element("more"));
    if (this.made < this.jobs.length) this.end.observe(element("more"));
  }

  makeCard(job) {
    const state = stateOf(job);
    const title = make("button", { type: "button", textContent: job.name || "(no name)" });
    const badge = make("span", { className: `badge ${state.replace(" ", "-")}`, textContent: state });
    const card = make(
      "article", { className: "card" },
      make("h3", {}, title, ...(state === "done" ? [] : [badge])),
      makeValues(job),
    );
    card.dataset.job = this.data.jobs.indexOf(job);
    if (job.image) card.append(this.makeCanvases(job), this.makeFigures(job));
    card.append(...makeTroubles(job));
    const seconds = make("span", { textContent: timeWords(job.seconds) });
    seconds.dataset.figure = "seconds";
    seconds.dataset.value = job.seconds;
    card.append(make("p", { className: "foot" }, makeLink(job), seconds));
    return card;
  }

  makeCanvases(job) {
    const { width, height } = job.image.thumbnail;
    const canvases = this.state.maps.map(() => {
      const canvas = make("canvas", { width, height });
      canvas.style.aspectRatio = `${width} / ${height}`;
      return canvas;
    });
    return make("div", { className: "canvases" }, ...canvases);
  }

  makeFigures(job) {
    const stokes = this.meanFor(job);
    const parts = ON_CARDS.map(([id, name]) => [name, this.figures.find((it) => it.id === id)]);
    const spans = parts.filter(([, figure]) => figure).map(([name, figure]) => {
      const value = figure.of(job, stokes);
      const words = make("b", { textContent: wordsOf(figure, value) });
      if (value !== undefined) words.dataset.value = value;
      words.dataset.figure = figure.id;
      return make("span", { title: `Mean ${name} of the image` }, `${name} `, words);
    });
    return make("p", { className: "figures" }, ...spans);
  }

  async paint(card) {
    const job = this.data.jobs[card.dataset.job];
    if (!job?.image) return;
    try {
      await this.maps.paint(job, [...card.querySelectorAll("canvas")]);
      card.dataset.painted = "yes";
    } catch (error) {
      card.append(make("p", { className: "trouble", textContent: error.message }));
    }
  }

  bindDialog() {
    this.dialog.addEventListener("click", (event) => {
      if (event.target === this.dialog) this.dialog.close();
    });
    document.addEventListener("keydown", (event) => {
      if (!this.dialog.open) return;
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      const now = this.jobs.indexOf(this.data.jobs[this.dialog.dataset.job]);
      const next = this.jobs[now + step];
      if (step && next) this.open(next);
    });
  }

  /** All that is known of a job. */
  open(job) {
    const { dialog, data } = this;
    dialog.dataset.job = data.jobs.indexOf(job);
    const close = make("button", { type: "button", textContent: "Close", className: "close" });
    close.addEventListener("click", () => dialog.close());
    const facts = [
      ["state", stateOf(job)], ["job file", job.jobs], ["number", job.index],
      ["seconds", job.seconds],
    ];
    if (job.image) {
      const { width, height, channels, components, many } = job.image;
      facts.push(["size", `${width} × ${height}`], ["channels", channels.join(", ")]);
      if (many) facts.push(["of", many]);
      facts.push(["components", components === 4 ? "S0 to S3" : "S0 alone"]);
    }
    const list = facts.flatMap(([key, value]) => [
      make("dt", { textContent: key }), make("dd", { textContent: value }),
    ]);
    const file = [make("dt", { textContent: "image" }), make("dd", {}, makeLink(job))];
    dialog.replaceChildren(
      close, make("h1", { id: "details-title", textContent: job.name || "(no name)" }),
      makeValues(job), ...makeTroubles(job),
      ...(job.image ? [this.makeCanvases(job)] : []),
      make("div", { className: "facts" }, make("dl", {}, ...list, ...file), this.makeMeans(job)),
    );
    if (!dialog.open) dialog.showModal();
    dialog.focus();
    this.paint(dialog);
  }

  /** The table of means, as the page of one image has it of a pixel. */
  makeMeans(job) {
    if (!job.image?.mean) return "";
    const values = job.image.mean.map((channels) => channels.map((mean) => [mean]));
    const image = { ...job.image, values, variances: null };
    const table = makeTable(image, 0, columnsOf(image, this.data.luminance));
    table.prepend(make("caption", { textContent: "Means of the whole image" }));
    return table;
  }
}
