// The page: reads its data, and puts the parts together.

const counted = (count, word) => `${count} ${word}${count === 1 ? "" : "s"}`;

/** What has become of the batch. */
function summaryOf(data) {
  const { jobs, broken } = data;
  if (jobs.length === 0) {
    return "There are no jobs in results.jsonl: `sunstone batch` adds a line for each that it has "
      + "rendered. Make this page again then.";
  }
  const counts = grouped(jobs, stateOf);
  const words = { failed: "failed", "no image": "without an image to show", changed: "changed since" };
  const parts = Object.entries(words).filter(([state]) => counts.has(state));
  const seconds = jobs.reduce((sum, job) => sum + job.seconds, 0);
  return [
    counted(jobs.length, "job"),
    ...parts.map(([state, text]) => `${counts.get(state).length} ${text}`),
    `${timeWords(seconds)} of work`,
    ...(broken > 0 ? [`${counted(broken, "line")} of results that cannot be read`] : []),
  ].join(" · ");
}

/** The exposure with which the middle one of the images is neither black nor white. */
function fittingExposure(jobs, meanFor) {
  const levels = jobs.map((job) => meanFor(job)?.[0]).filter((level) => level > 0);
  const level = levels.sort((a, b) => a - b)[levels.length >> 1] ?? 0.2;
  return level >= 0.02 && level <= 1 ? 0 : Math.max(-10, Math.min(10, Math.round(Math.log2(0.2 / level))));
}

/** The choices beside the maps. */
function bindShowing(data, state, { onPaint, onFigures }) {
  const colored = data.jobs.find((job) => job.image?.channels.length === 3);
  if (colored) {
    const names = colored.image.channels.map((name, index) => [String(index), name]);
    element("channel").append(...[["", "All (figures: luminance)"], ...names].map(([value, text]) => {
      return make("option", { value, textContent: text });
    }));
    element("channel").addEventListener("change", (event) => {
      state.channel = event.target.value === "" ? null : Number(event.target.value);
      onFigures();
    });
  }
  element("channel-row").hidden = !colored;
  element("end").append(...data.ends.map((end, index) => {
    const fits = index === data.end ? ", fits the images" : "";
    return make("option", { value: index, textContent: threeDigits(Math.fround(end)) + fits });
  }));
  element("end").value = String(state.end);
  element("end").addEventListener("change", (event) => {
    state.end = Number(event.target.value);
    onPaint();
  });
  const showExposure = () => {
    element("exposure").value = String(state.exposure);
    element("exposure-words").textContent = `${minus(String(state.exposure))} EV`;
  };
  element("exposure").addEventListener("input", (event) => {
    state.exposure = event.target.valueAsNumber;
    showExposure();
    onPaint();
  });
  showExposure();
  const size = () => {
    element("cards").style.setProperty("--side", `${element("size").value}px`);
    element("cards").style.setProperty("--maps", state.maps.length);
  };
  element("size").addEventListener("input", size);
  size();
  element("showing").hidden = false;
}

function bindKeys() {
  const focus = { "/": "search", p: "chart" };
  document.addEventListener("keydown", (event) => {
    const typing = event.target.matches("select, input:not([type=checkbox]):not([type=range])");
    if (typing || event.ctrlKey || event.metaKey || event.altKey || element("details").open) return;
    const key = event.key.toLowerCase();
    const target = key === "j" ? document.querySelector(".card button") : element(focus[key]);
    if (!target || target.closest("[hidden]")) return;
    target.focus();
    event.preventDefault();
  });
}

/** Sorting: by any quantity, either way; jobs without a value come last. */
function bindSort(quantities, state, onChange) {
  const select = element("sort");
  const choices = [...quantities].sort((a, b) => (b.id === "index") - (a.id === "index"));
  select.append(...choices.map(({ id, title }) => make("option", { value: id, textContent: title })));
  [state.sort] = choices;
  state.isTurned = false;
  select.addEventListener("change", () => {
    state.sort = choices.find(({ id }) => id === select.value);
    onChange();
  });
  element("turn").addEventListener("click", () => {
    state.isTurned = !state.isTurned;
    element("turn").textContent = state.isTurned ? "↓" : "↑";
    element("turn").setAttribute("aria-pressed", String(state.isTurned));
    onChange();
  });
}

function sorted(jobs, { sort, isTurned }, meanFor) {
  const values = new Map(jobs.map((job) => [job, sort.of(job, meanFor(job))]));
  const way = isTurned ? -1 : 1;
  return [...jobs].sort((a, b) => {
    const [first, second] = [values.get(a), values.get(b)];
    if (first === undefined || second === undefined) {
      return (first === undefined) - (second === undefined);
    }
    return way * (first - second);
  });
}

function save(text, name) {
  const link = make("a", { href: URL.createObjectURL(new Blob([text], { type: "text/csv" })) });
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

function start(data) {
  const { jobs } = data;
  const state = { channel: null, end: data.end, exposure: 0, maps: [] };
  const meanFor = (job) => meanOf(job, state.channel, data.luminance);
  const shown = jobs.filter((job) => job.image);
  state.exposure = fittingExposure(shown, meanFor);
  const axes = axesOf(jobs);
  const quantities = quantitiesOf(axes, {
    hasImages: shown.length > 0, isPolarized: shown.some((job) => isPolarized(job.image)),
  });
  const maps = shown.length === 0 ? null : new Maps(data, state, new Palette(data), {
    onChange: () => { maps.show(); cards.repaint(); },
  });
  const cards = new Cards(data, state, { maps, figures: quantities, meanFor });
  const filters = new Filters(jobs, axes, { onChange: () => update() });
  let visible = jobs;
  const update = () => {
    visible = sorted(filters.of(jobs), state, meanFor);
    const of = visible.length < jobs.length ? ` of ${jobs.length}` : "";
    element("count").textContent = `${visible.length}${of} ${jobs.length === 1 ? "job" : "jobs"}`;
    cards.show(visible);
    plot.show(visible);
  };
  const plot = new Plot(quantities, state, {
    onChange: () => plot.show(visible), onOpen: (job) => cards.open(job), meanFor,
  });
  bindSort(quantities, state, update);
  if (maps) {
    bindShowing(data, state, {
      onPaint: () => { maps.show(); cards.repaint(); },
      onFigures: () => { maps.show(); update(); },
    });
  }
  element("save").addEventListener("click", () => {
    save(tableOf(visible, quantities, meanFor), `${data.name.replace(/[^\w.-]+/g, "-")}.csv`);
  });
  element("plot").hidden = false;
  element("sorting").hidden = false;
  bindKeys();
  update();
}

function main() {
  checkBrowser();
  const data = JSON.parse(element("data").textContent);
  element("name").textContent = data.name;
  element("summary").textContent = summaryOf(data);
  if (data.jobs.length > 0) start(data);
  element("message").hidden = true;
  document.documentElement.dataset.ready = "yes";
}

try {
  main();
} catch (error) {
  element("message").textContent = `This page cannot be shown: ${error.message}`;
  element("message").classList.add("error");
}
