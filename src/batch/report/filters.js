// Filters: which jobs are shown.

/** Values of an axis that are choices to click; more of them are a range or words. */
const CHOICES_MAX = 16;

/** The filters of a page: `passes` says whether a job is shown. */
class Filters {
  constructor(jobs, axes, { onChange }) {
    this.onChange = onChange;
    this.tests = [];
    this.add("State", jobs, stateOf);
    this.add("Job file", jobs, (job) => job.jobs);
    this.add("Name", jobs, (job) => job.name);
    for (const { name, values, isNumeric } of axes) {
      if (values.length > CHOICES_MAX && isNumeric) this.addRange(name, values);
      else this.add(name, jobs, (job) => valueOf(job, name));
    }
    const search = element("search");
    search.addEventListener("input", onChange);
    const texts = new Map();
    const textOf = (job) => {
      if (!texts.has(job)) {
        const words = [job.name, job.output, job.error, job.problem];
        texts.set(job, words.join("\n").toLowerCase());
      }
      return texts.get(job);
    };
    this.tests.push({
      isOn: () => search.value.trim() !== "",
      passes: (job) => {
        const words = search.value.toLowerCase().split(/\s+/);
        return words.every((word) => textOf(job).includes(word));
      },
      reset: () => { search.value = ""; },
    });
    element("reset").addEventListener("click", () => {
      for (const test of this.tests) test.reset();
      element("search").focus();
      onChange();
    });
  }

  /** Choices of what jobs have, if they are not all alike and not too many. */
  add(title, jobs, of) {
    const key = (job) => JSON.stringify(of(job) ?? null);
    const counts = new Map();
    for (const job of jobs) counts.set(key(job), (counts.get(key(job)) ?? 0) + 1);
    if (counts.size < 2 || counts.size > CHOICES_MAX) return;
    const keys = [...counts.keys()].sort((a, b) => {
      const [first, second] = [JSON.parse(a), JSON.parse(b)];
      if (first === null || second === null) return (first === null) - (second === null);
      return typeof first === "number" && typeof second === "number" ? first - second : 0;
    });
    const inputs = keys.map((value) => make("input", { type: "checkbox", value }));
    const labels = inputs.map((input) => {
      const value = JSON.parse(input.value);
      input.addEventListener("change", this.onChange);
      const words = value === null ? "none" : valueWords(value);
      const count = make("small", { textContent: counts.get(input.value) });
      return make("label", { title: words }, input, make("span", {}, words, " ", count));
    });
    this.addRow(title, make("div", { className: "chips" }, ...labels));
    const chosen = () => inputs.filter((input) => input.checked);
    this.tests.push({
      isOn: () => chosen().length > 0,
      passes: (job) => chosen().some((input) => input.value === key(job)),
      reset: () => { for (const input of inputs) input.checked = false; },
    });
  }

  /** From one number to another. */
  addRange(title, values) {
    const inputs = [["from", values[0]], ["to", values.at(-1)]].map(([word, value]) => {
      const input = make("input", { type: "number", step: "any", placeholder: plainNumber(value) });
      input.setAttribute("aria-label", `${title} ${word}`);
      input.addEventListener("input", this.onChange);
      return input;
    });
    const [from, to] = inputs;
    this.addRow(title, make("div", { className: "range" }, from, "to", to));
    this.tests.push({
      isOn: () => inputs.some((input) => Number.isFinite(input.valueAsNumber)),
      passes: (job) => {
        const value = valueOf(job, title);
        return value !== undefined && !(value < from.valueAsNumber) && !(value > to.valueAsNumber);
      },
      reset: () => { for (const input of inputs) input.value = ""; },
    });
  }

  addRow(title, body) {
    const row = make("fieldset", {}, make("legend", { textContent: title }), body);
    row.dataset.filter = title;
    element("filters").append(row);
  }

  /** The jobs that pass. */
  of(jobs) {
    const tests = this.tests.filter((test) => test.isOn());
    element("reset").hidden = tests.length === 0;
    return jobs.filter((job) => tests.every((test) => test.passes(job)));
  }
}
