// The mixture of four causes, its log likelihood, and the rounds of EM: reference/sensors/plain_beam_learning.py.
// A model is { shares: [hit, short, beyond, random], sigma, rate, reach }; every beam expects the same distance.

const NARROWEST = 1e-3;
const WITNESSES = 1e-9;

/** The density of each cause at z, times its share. */
export function parts(z, expected, { shares, sigma, rate, reach }) {
  return [
    (shares[0] * Math.exp(-0.5 * ((z - expected) / sigma) ** 2)) / (sigma * Math.sqrt(2 * Math.PI)),
    z <= expected ? shares[1] * rate * Math.exp(-rate * z) : 0,
    z >= reach ? shares[2] : 0,
    shares[3] / reach,
  ];
}

function sum(ones) {
  return ones.reduce((total, one) => total + one, 0);
}

/** The logarithm of the likelihood of all the ranges; −∞ where one of them cannot be. */
export function logLikelihood(read, expected, model) {
  return sum(read.map((z) => Math.log(sum(parts(z, expected, model)))));
}

/** Of each range, the probability of each cause: they sum to one. Null where the model makes it impossible. */
export function causes(read, expected, model) {
  return read.map((z) => {
    const all = parts(z, expected, model);
    const total = sum(all);
    return total > 0 ? all.map((one) => one / total) : null;
  });
}

/** One round: whose cause, then the parameters that suit these causes best. Null where some range is impossible. */
export function round(read, expected, model) {
  const due = causes(read, expected, model);
  if (due.includes(null)) return null;
  const owed = [0, 1, 2, 3].map((cause) => sum(due.map((one) => one[cause])));
  const squares = sum(due.map((one, k) => one[0] * (read[k] - expected) ** 2));
  const lengths = sum(due.map((one, k) => one[1] * read[k]));
  const all = sum(owed);
  return {
    reach: model.reach,
    shares: owed.map((one) => one / all),
    sigma: owed[0] > WITNESSES ? Math.max(NARROWEST, Math.sqrt(squares / owed[0])) : model.sigma,
    rate: owed[1] > WITNESSES && lengths > 0 ? owed[1] / lengths : model.rate,
  };
}

/** Rounds until one gains less than `least`, or `most` of them: the last model, and how many there were. */
export function settle(read, expected, model, least = 1e-4, most = 500) {
  let [now, told] = [model, logLikelihood(read, expected, model)];
  for (let k = 0; k < most; k += 1) {
    const next = round(read, expected, now);
    if (next === null) return { model: now, rounds: k };
    const better = logLikelihood(read, expected, next);
    if (!(better - told >= least)) return { model: now, rounds: k };
    [now, told] = [next, better];
  }
  return { model: now, rounds: most };
}

/** How many of the ranges fall into each of the bins below `reach`, and the rest: those that saw nothing. */
export function histogram(read, reach, width) {
  const counts = Array.from({ length: Math.round(reach / width) + 1 }, () => []);
  read.forEach((z, k) => counts[Math.min(Math.floor(z / width + 1e-9), counts.length - 1)].push(k));
  return counts;
}
