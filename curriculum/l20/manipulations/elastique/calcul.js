// A chain of n measurements on a line, each of standard deviation sigma, and a closure of standard deviation bound that
// misses by gap: theorem « fermeture de boucle » in one dimension. Lengths in one unit.

/**
 * Of the poses 0 to n: `shifts`, by how much the closure moves them; `open` and `closed`, their standard deviations
 * before and after. Of the whole: what each link yields (`each`), what the closure keeps (`left`), and `chi2`.
 */
export function chain(n, sigma, bound, gap) {
  const [one, all, end] = [sigma ** 2, n * sigma ** 2, bound ** 2];
  const poses = Array.from({ length: n + 1 }, (_, k) => k * one);
  return {
    shifts: poses.map((so) => (gap * so) / (all + end)),
    open: poses.map(Math.sqrt),
    closed: poses.map((so) => Math.sqrt((so * (all - so + end)) / (all + end))),
    each: (gap * one) / (all + end),
    left: (gap * end) / (all + end),
    chi2: gap ** 2 / (all + end),
  };
}
