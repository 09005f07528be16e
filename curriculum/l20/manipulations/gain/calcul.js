// The Kalman filter on a line, measured directly, and what a gain that never changes makes of the same path:
// reference/filters/kalman.py, with F = H = 1. Standard deviations in one unit of length.

/** The prediction N(mean, spread²) corrected by a measurement z of standard deviation noise. */
export function fuse(mean, spread, z, noise) {
  const gain = spread ** 2 / (spread ** 2 + noise ** 2);
  const surprise = Math.abs(z - mean) / Math.hypot(spread, noise);
  return { gain, mean: mean + gain * (z - mean), spread: noise * Math.sqrt(gain), surprise };
}

/** The density of N(mean, spread²) at x. */
export function bell(x, mean, spread) {
  return Math.exp(-0.5 * ((x - mean) / spread) ** 2) / (spread * Math.sqrt(2 * Math.PI));
}

/** The gain of each of n corrections: the filter's own, or `fixed` where that is a number. */
export function gains(spread, move, noise, n, fixed = null) {
  let variance = spread ** 2;
  return Array.from({ length: n }, (_, k) => {
    if (k > 0) variance += move ** 2;
    const gain = variance / (variance + noise ** 2);
    variance *= 1 - gain;
    return fixed ?? gain;
  });
}

/** The standard deviation of the error after each correction: (1 − K)² P + K² R, for whatever gain. */
export function typical(spread, move, noise, used) {
  let variance = spread ** 2;
  return used.map((gain, k) => {
    if (k > 0) variance += move ** 2;
    variance = (1 - gain) ** 2 * variance + gain ** 2 * noise ** 2;
    return Math.sqrt(variance);
  });
}

/** The error after each correction on one path: `moves` and `readings` are its draws, of mean 0 and variance 1. */
export function path(spread, move, noise, used, moves, readings) {
  let error = spread * moves[0];
  return used.map((gain, k) => {
    if (k > 0) error += move * moves[k];
    error += gain * (noise * readings[k] - error);
    return error;
  });
}
