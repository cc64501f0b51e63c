// Figures of jobs: what they are sorted by, plotted and read as.

/** What is alike, by what `keyOf` says of it. */
function grouped(list, keyOf) {
  const groups = new Map();
  for (const item of list) {
    const key = keyOf(item);
    if (!groups.has(key)) groups.set(key, []);
    groups.get(key).push(item);
  }
  return groups;
}

/** What has become of a job. */
function stateOf(job) {
  if (job.error !== null) return "failed";
  if (job.problem !== null) return "no image";
  return job.changed ? "changed" : "done";
}

/** A time in words. */
function timeWords(seconds) {
  if (seconds < 120) return `${threeDigits(seconds)} s`;
  if (seconds < 7200) return `${(seconds / 60).toFixed(1)} min`;
  return `${(seconds / 3600).toFixed(1)} h`;
}

/** The mean Stokes vector of an image, of a channel or with none of luminance, if there is one. */
function meanOf(job, channel, luminance) {
  const mean = job.image?.mean;
  if (!mean) return null;
  const isColored = mean[0].length === 3;
  if (channel !== null || !isColored) {
    return mean.map((channels) => channels[Math.min(channel ?? 0, channels.length - 1)]);
  }
  return mean.map((channels) => times(luminance, ...channels));
}

/** A figure of light: where there is none it has no value, nor an angle without a degree. */
const ofLight = (figure, factor, needed) => (stokes) => {
  if (stokes?.length !== 4 || !(stokes[0] > 0)) return undefined;
  const light = polarizationOf(stokes);
  return needed && !(light[needed] > 0) ? undefined : factor * light[figure];
};

const inDegrees = 180 / Math.PI;

/** Figures of an image, from its mean Stokes vector: id, title, unit, value. */
const FIGURES_OF_IMAGES = [
  ["s0", "S0", "", (stokes) => stokes?.[0]],
  ["s1", "S1", "", (stokes) => stokes?.[1]],
  ["s2", "S2", "", (stokes) => stokes?.[2]],
  ["s3", "S3", "", (stokes) => stokes?.[3]],
  ["s1/s0", "S1/S0", "", shareOf(1)],
  ["s2/s0", "S2/S0", "", shareOf(2)],
  ["s3/s0", "S3/S0", "", shareOf(3)],
  ["dop", "Degree of polarization", "", ofLight("dop", 1)],
  ["dolp", "Degree of linear polarization", "", ofLight("dolp", 1)],
  ["aolp", "Angle of linear polarization", "°", ofLight("aolp", inDegrees, "dolp")],
  ["ellipticity", "Ellipticity", "°", ofLight("ellipticity", inDegrees, "dop")],
];

function shareOf(component) {
  return (stokes) => (stokes?.length === 4 && stokes[0] > 0 ? stokes[component] / stokes[0] : undefined);
}

/** The value that a job has on an axis, if it has one; names may be those that objects have. */
const valueOf = (job, name) => (Object.hasOwn(job.values, name) ? job.values[name] : undefined);

/** A number without what rounding has added. */
const plainNumber = (value) => (
  Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(12))));

/** A value of an axis in words. */
function valueWords(value) {
  if (typeof value === "number") return minus(plainNumber(value));
  return typeof value === "string" && value !== "" ? value : JSON.stringify(value);
}

/** The axes of all sweeps: names, and the values that there are, numbers in their order. */
function axesOf(jobs) {
  const axes = new Map();
  for (const job of jobs) {
    for (const [name, value] of Object.entries(job.values)) {
      if (!axes.has(name)) axes.set(name, new Map());
      axes.get(name).set(JSON.stringify(value), value);
    }
  }
  return [...axes].map(([name, found]) => {
    const values = [...found.values()];
    const isNumeric = values.every((value) => typeof value === "number");
    if (isNumeric) values.sort((a, b) => a - b);
    const places = new Map(values.map((value, place) => [JSON.stringify(value), place]));
    return { name, values, isNumeric, places };
  });
}

/**
 * All that jobs can be told apart by: `of` gives a number or nothing, `words` says it. Axes of
 * words have their places for numbers.
 */
function quantitiesOf(axes, { hasImages, isPolarized: isAnyPolarized }) {
  const swept = axes.map((axis) => ({
    id: `axis:${axis.name}`,
    title: axis.name,
    unit: "",
    axis,
    of: (job) => {
      const value = valueOf(job, axis.name);
      if (value === undefined) return undefined;
      return axis.isNumeric ? value : axis.places.get(JSON.stringify(value));
    },
  }));
  const known = FIGURES_OF_IMAGES.filter(([id]) => hasImages && (isAnyPolarized || id === "s0"));
  const figures = known.map(([id, title, unit, figure]) => {
    return { id, title: `Mean ${title}`.replace(/Mean (?=[DAE])/, ""), unit, of: (_, stokes) => figure(stokes) };
  });
  return [
    ...swept,
    ...figures,
    { id: "seconds", title: "Seconds", unit: " s", of: (job) => job.seconds },
    { id: "index", title: "Number of the job", unit: "", of: (job) => job.index },
  ];
}

/** A value of a quantity in words. */
function wordsOf(quantity, value) {
  if (value === undefined) return "–";
  if (quantity.axis) return valueWords(quantity.axis.isNumeric ? value : quantity.axis.values[value]);
  if (quantity.id === "index") return String(value);
  return shortNumber(value) + quantity.unit;
}

/** The jobs as a table of values between commas, with all digits. */
function tableOf(jobs, quantities, meanFor) {
  const cell = (value) => {
    const text = String(value ?? "");
    return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  const numbers = quantities.filter(({ axis }) => !axis);
  const axes = quantities.filter(({ axis }) => axis);
  const head = ["file", "name", ...axes.map(({ title }) => title), "state", "output", "cause"];
  const rows = jobs.map((job) => {
    const stokes = meanFor(job);
    const values = axes.map(({ title }) => {
      const value = valueOf(job, title);
      return typeof value === "object" ? JSON.stringify(value) : value;
    });
    return [
      job.jobs, job.name, ...values, stateOf(job), job.output, job.error ?? job.problem,
      ...numbers.map((quantity) => quantity.of(job, stokes)),
    ];
  });
  const lines = [[...head, ...numbers.map(({ id }) => id)], ...rows];
  return lines.map((row) => row.map(cell).join(",")).join("\n") + "\n";
}
