// Stokes vectors: x to the right in the image, y up, light towards the sensor; S3 > 0 is right
// circular, clockwise as one looks at the image.

/**
 * What lets light through, as weights of S0 to S3: an ideal analyzer's intensity is their sum.
 * A linear one at an angle a from x towards y: (S0 + S1 cos 2a + S2 sin 2a) / 2.
 */
function analyzerWeights(kind, degrees) {
  const double = (2 * degrees * Math.PI) / 180;
  switch (kind) {
    case "linear": return [0.5, 0.5 * Math.cos(double), 0.5 * Math.sin(double), 0];
    case "right": return [0.5, 0, 0, 0.5];
    case "left": return [0.5, 0, 0, -0.5];
    default: return [1, 0, 0, 0];
  }
}

const isPolarized = (image) => image.components === 4;

/** The intensity of a channel behind an analyzer: a function of the pixel. */
function analyzedReader(image, channel, weights) {
  const planes = image.values.map((channels) => channels[Math.min(channel, channels.length - 1)]);
  const [s0, s1, s2, s3] = planes;
  const [w0, w1, w2, w3] = weights;
  if (w0 === 1) return (pixel) => s0[pixel];
  // A weight of nothing is no product: a value that is not finite would show through it.
  if (w3 !== 0) return (pixel) => w0 * s0[pixel] + w3 * s3[pixel];
  return (pixel) => w0 * s0[pixel] + w1 * s1[pixel] + w2 * s2[pixel];
}

/**
 * Reads Stokes vectors into an array of four: those of a channel, or with none those of luminance,
 * which maps show.
 */
function stokesReader(image, channel, luminance) {
  const channels = image.channels.length;
  if (channel === null && channels === 3) {
    const [r, g, b] = luminance;
    const values = image.values;
    return (pixel, stokes) => {
      for (let i = 0; i < 4; i += 1) {
        const planes = values[i];
        stokes[i] = r * planes[0][pixel] + g * planes[1][pixel] + b * planes[2][pixel];
      }
    };
  }
  const planes = image.values.map((list) => list[Math.min(channel ?? 0, channels - 1)]);
  return (pixel, stokes) => {
    for (let i = 0; i < 4; i += 1) stokes[i] = planes[i][pixel];
  };
}

/** Degrees and angles of a Stokes vector; where there is no light, degrees are 0. */
function polarizationOf([s0, s1, s2, s3]) {
  // In double precision squares of 32-bit floats neither overflow nor vanish.
  const linear = Math.sqrt(s1 * s1 + s2 * s2);
  const polarized = Math.sqrt(linear * linear + s3 * s3);
  const share = (part) => (s0 > 0 ? part / s0 : 0);
  return {
    dop: share(polarized),
    dolp: share(linear),
    circular: share(s3),
    linearShare: polarized > 0 ? linear / polarized : 0,
    aolp: angleOf(s1, s2),
    ellipticity: 0.5 * Math.atan2(s3, linear),
  };
}

/** The angle of linear polarization in [0, pi). */
function angleOf(s1, s2) {
  const angle = 0.5 * Math.atan2(s2, s1);
  const turned = angle < 0 ? angle + Math.PI : angle;
  return turned < Math.PI ? turned : 0;
}

/** Whether a map has something to show: light, and numbers. */
function isLit([s0, s1, s2, s3]) {
  return s0 > 0 && Number.isFinite(s0) && Number.isFinite(s1) && Number.isFinite(s2)
    && Number.isFinite(s3);
}
