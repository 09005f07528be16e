// The beams of a lidar, somebody in their way, and two likelihoods of what was read: reference/sensors/beam.py, (4).

/** Where a ray from (x, y) at `angle` meets a disc, or Infinity; 0 from inside it. */
export function meets([x, y], angle, [cx, cy], radius) {
  const [dx, dy] = [cx - x, cy - y];
  if (Math.hypot(dx, dy) <= radius) return 0;
  const along = dx * Math.cos(angle) + dy * Math.sin(angle);
  const across = dy * Math.cos(angle) - dx * Math.sin(angle);
  if (along < 0 || Math.abs(across) >= radius) return Infinity;
  return along - Math.sqrt(radius ** 2 - across ** 2);
}

/** What each beam reads: the walker where they stop it before `read`, with the same noise. */
export function ranges(pose, angles, read, noise, walker, radius) {
  return angles.map((angle, k) => {
    const met = meets(pose, pose[2] + angle, walker, radius);
    return met < read[k] ? Math.max(0, Math.min(met + noise[k], read[k])) : read[k];
  });
}

/** The logarithm of the Gaussian alone, without its constant: minus the sum of the squares over 2 σ². */
export function gaussian(z, expected, sigma) {
  return -z.reduce((sum, one, k) => sum + (one - expected[k]) ** 2, 0) / (2 * sigma ** 2);
}

/** The logarithm of one beam under the mixture. `shares`: [hit, short, beyond, random]. */
export function mixtureOf(z, expected, { sigma, shares, rate, reach }) {
  const [hit, short, beyond, random] = shares;
  const bell = Math.exp(-0.5 * ((z - expected) / sigma) ** 2) / (sigma * Math.sqrt(2 * Math.PI));
  const unexpected = z <= expected ? rate * Math.exp(-rate * z) : 0;
  return Math.log(hit * bell + short * unexpected + beyond * (z >= reach ? 1 : 0) + random / reach);
}

export function mixture(z, expected, model) {
  return z.reduce((sum, one, k) => sum + mixtureOf(one, expected[k], model), 0);
}
