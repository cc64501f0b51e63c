// The plot: a figure of the jobs over another, a line for every value of a third.

const PLOT = { left: 64, right: 16, top: 12, bottom: 34, height: 260 };
/** Most lines of different colors; with more of them, a quantity makes no lines. */
const LINES_MAX = 24;

/** Whether there is a number that has a place. */
const isPlaced = (value) => Math.abs(value) < 1e300;

/** Round numbers from one to another, about `count` of them. */
function ticksOf(least, most, count) {
  const rough = (most - least) / count;
  const unit = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * unit).find((size) => size >= rough) ?? rough;
  const first = Math.ceil(least / step - 1e-9);
  const last = Math.floor(most / step + 1e-9);
  const ticks = [];
  for (let i = first; i <= last; i += 1) ticks.push(Number((i * step).toPrecision(12)));
  return ticks;
}

/** Where a quantity lies on a side of the plot: its ends with some air, ticks, and a function. */
function scaleOf(quantity, values, [start, end]) {
  let [least, most] = values.reduce(([a, b], value) => [Math.min(a, value), Math.max(b, value)],
    [Infinity, -Infinity]);
  const isWords = quantity.axis && !quantity.axis.isNumeric;
  // What is told apart by rounding alone lies at one place.
  const size = Math.max(Math.abs(least), Math.abs(most));
  const isOne = most - least <= 1e-9 * size;
  const air = isWords ? 0.5 : isOne ? 0.05 * size || 1 : 0.04 * (most - least);
  [least, most] = [least - air, most + air];
  const count = Math.max(2, Math.abs(end - start) / (start < end ? 80 : 45));
  const isWhole = (tick) => Number.isInteger(tick) && quantity.axis.values[tick] !== undefined;
  const ticks = ticksOf(least, most, count).filter((tick) => !isWords || isWhole(tick));
  const at = (value) => start + ((value - least) / (most - least)) * (end - start);
  const words = (tick) => (isWords
    ? wordsOf(quantity, tick).slice(0, 16) : minus(String(tick)) + quantity.unit.trim());
  return { at, ticks: ticks.map((tick) => [at(tick), words(tick)]) };
}

/** The plot of a page; `onOpen` is told which job is asked for. */
class Plot {
  constructor(quantities, state, { onChange, onOpen, meanFor }) {
    Object.assign(this, { quantities, state, onOpen, meanFor, points: [], jobs: [], marked: null });
    this.chart = element("chart");
    const axes = quantities.filter(({ axis }) => axis);
    const swept = axes.filter(({ axis }) => axis.values.length > 1);
    const first = [...swept].sort((a, b) => b.axis.values.length - a.axis.values.length)
      .find(({ axis }) => axis.isNumeric) ?? swept[0];
    const others = swept.filter((other) => other !== first && other.axis.values.length <= LINES_MAX);
    this.bind("plot-y", quantities, "y", quantities.find(({ id }) => id === "s0") ?? quantities.at(-2));
    this.bind("plot-x", quantities, "x", first ?? quantities.at(-1));
    const none = { id: "", title: "nothing: one line" };
    this.bind("plot-series", [none, ...axes.filter(({ axis }) => axis.values.length <= LINES_MAX)],
      "series", others[0] ?? none);
    for (const part of document.querySelectorAll(".series-choice")) part.hidden = axes.length === 0;
    this.onChange = onChange;
    this.bindPointer();
    new ResizeObserver(() => this.draw()).observe(this.chart);
  }

  bind(id, choices, key, chosen) {
    const select = element(id);
    select.append(...choices.map((it) => make("option", { value: it.id, textContent: it.title })));
    select.value = chosen.id;
    this.state[key] = chosen;
    select.addEventListener("change", () => {
      this.state[key] = choices.find((choice) => choice.id === select.value);
      this.onChange();
    });
  }

  bindPointer() {
    const pointOf = (event) => this.points[event.target.dataset?.point];
    this.chart.addEventListener("pointermove", (event) => this.mark(pointOf(event) ?? null));
    this.chart.addEventListener("pointerleave", () => this.mark(null));
    this.chart.addEventListener("click", (event) => {
      const point = pointOf(event);
      if (point) this.onOpen(point.job);
    });
    this.chart.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (event.key === "Enter" && this.marked) this.onOpen(this.marked.job);
      if (!step || this.points.length === 0) return;
      const now = this.points.indexOf(this.marked);
      const next = now < 0 && step < 0 ? this.points.length - 1 : now + step;
      this.mark(this.points[Math.max(0, Math.min(next, this.points.length - 1))]);
      event.preventDefault();
    });
  }

  show(jobs) {
    this.jobs = jobs;
    this.marked = null;
    this.draw();
  }

  /** The jobs that have both values, from left to right. */
  place() {
    const { x, y, series } = this.state;
    const points = [];
    for (const job of this.jobs) {
      const stokes = this.meanFor(job);
      const point = { job, x: x.of(job, stokes), y: y.of(job, stokes) };
      point.series = series.axis ? series.of(job) ?? null : null;
      if (isPlaced(point.x) && isPlaced(point.y)) points.push(point);
    }
    return points.sort((a, b) => a.x - b.x || a.series - b.series);
  }

  draw() {
    const { chart, state } = this;
    const width = Math.max(240, chart.clientWidth);
    chart.setAttribute("viewBox", `0 0 ${width} ${PLOT.height}`);
    this.points = this.place();
    element("plot-legend").replaceChildren();
    this.say();
    chart.setAttribute("aria-label", `${state.y.title} over ${state.x.title}`);
    if (this.points.length === 0) {
      const middle = { x: width / 2, y: PLOT.height / 2, class: "tick-label middle" };
      chart.replaceChildren(svg("text", middle, "No job that is shown has both values."));
      return;
    }
    const side = [PLOT.left, width - PLOT.right];
    const height = [PLOT.height - PLOT.bottom, PLOT.top];
    const across = scaleOf(state.x, this.points.map((point) => point.x), side);
    const up = scaleOf(state.y, this.points.map((point) => point.y), height);
    for (const point of this.points) point.at = [across.at(point.x), up.at(point.y)];
    chart.replaceChildren(
      this.makeGrid(across, up, side, height), ...this.makeLines(across, up), this.makePoints(),
      svg("circle", { r: 8, class: "mark", visibility: "hidden" }),
    );
  }

  makeGrid(across, up, [left, right], [bottom, top]) {
    const { x, y } = this.state;
    const grid = svg("g", { class: "grid" });
    for (const [at, words] of across.ticks) {
      grid.append(svg("line", { x1: at, x2: at, y1: bottom, y2: top }));
      grid.append(svg("text", { x: at, y: bottom + 15, class: "tick-label middle" }, words));
    }
    for (const [at, words] of up.ticks) {
      grid.append(svg("line", { x1: left, x2: right, y1: at, y2: at }));
      grid.append(svg("text", { x: left - 6, y: at + 4, class: "tick-label end" }, words));
    }
    grid.append(svg("text", { x: right, y: bottom + 30, class: "title end" }, x.title));
    grid.append(svg("text", { x: left, y: top - 2, class: "title" }, y.title));
    return grid;
  }

  /** A line through every series, where it is plotted over an axis. */
  makeLines(across, up) {
    const { x, y, series } = this.state;
    const groups = grouped(this.points, (point) => point.series);
    const keys = [...groups.keys()].sort((a, b) => a - b);
    keys.forEach((key, place) => {
      for (const point of groups.get(key)) point.color = this.colorOf(place, keys.length);
    });
    if (series.axis) this.showSeries(keys);
    if (!x.axis) return [];
    return keys.map((key, place) => {
      let path = "";
      let before = null;
      for (const [at, points] of grouped(groups.get(key), (point) => point.x)) {
        const mean = points.reduce((sum, point) => sum + point.y, 0) / points.length;
        // An angle that goes on beyond 180 degrees begins at 0.
        const isTurned = y.id === "aolp" && Math.abs(mean - before) > 90;
        path += `${before === null || isTurned ? "M" : "L"}${across.at(at)} ${up.at(mean)}`;
        before = mean;
      }
      return svg("path", { d: path, class: "line", stroke: this.colorOf(place, keys.length) });
    });
  }

  colorOf(place, count) {
    if (count <= 8) return `var(--series-${place})`;
    return `hsl(${(360 * place) / count} 65% var(--series-lightness))`;
  }

  showSeries(keys) {
    const { series } = this.state;
    const names = keys.map((key, place) => {
      const swatch = make("i");
      swatch.style.background = this.colorOf(place, keys.length);
      const words = key === null ? "none" : wordsOf(series, key);
      return make("span", { className: "swatch" }, swatch, words);
    });
    element("plot-legend").append(make("b", { textContent: series.title }), ...names);
  }

  makePoints() {
    const radius = this.points.length > 1000 ? 2 : 3.5;
    const group = svg("g", { class: "points" });
    this.points.forEach((point, index) => {
      const [cx, cy] = point.at;
      group.append(svg("circle", {
        cx, cy, r: radius, fill: point.color,
        "data-point": index, "data-x": point.x, "data-y": point.y, "data-series": point.series,
      }));
    });
    return group;
  }

  mark(point) {
    this.marked = point;
    const circle = this.chart.querySelector(".mark");
    if (!circle) return;
    circle.setAttribute("visibility", point ? "visible" : "hidden");
    if (point) {
      circle.setAttribute("cx", point.at[0]);
      circle.setAttribute("cy", point.at[1]);
    }
    this.say();
  }

  /** What is under the pointer, or what the plot is of. */
  say() {
    const { points, jobs, marked, state: { x, y, series } } = this;
    const without = jobs.length - points.length;
    let words = without > 0 ? `${without} of ${jobs.length} jobs without such values. ` : "";
    const isMean = x.axis && new Set(points.map((point) => `${point.x} ${point.series}`)).size
      < points.length;
    if (isMean) words += "Lines go through the means of jobs at one place.";
    if (marked) {
      const { job } = marked;
      const name = `${job.name} (${job.index})`;
      const more = series.axis && series !== x ? `, ${series.title} ${wordsOf(series, marked.series ?? undefined)}` : "";
      words = `${name}: ${y.title} ${wordsOf(y, marked.y)} at ${x.title} ${wordsOf(x, marked.x)}${more}`;
    }
    element("plot-words").textContent = words || "A click on a point opens its job.";
  }
}
