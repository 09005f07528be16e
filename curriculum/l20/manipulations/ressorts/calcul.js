// What a graph of poses in the plane costs, and a step of Gauss-Newton: reference/pose_graph, for a few dozen poses.
// A pose is [x, y, theta]; an edge { i, j, z, information }, the three diagonal terms of its matrix. Angles in radians.

const turned = (angle) => angle - 2 * Math.PI * Math.ceil((angle - Math.PI) / (2 * Math.PI)); // into ]−π, π]

/** The error [ex, ey, etheta] of an edge between two poses. */
export function residual([xi, yi, ai], [xj, yj, aj], [zx, zy, za]) {
  const [c, s, dx, dy] = [Math.cos(ai), Math.sin(ai), xj - xi, yj - yi];
  return [c * dx + s * dy - zx, -s * dx + c * dy - zy, turned(aj - ai - za)];
}

/** χ² of each edge. */
export function edgeChi2(edges, poses) {
  return edges.map(({ i, j, z, information }) =>
    residual(poses[i], poses[j], z).reduce((sum, e, k) => sum + information[k] * e * e, 0),
  );
}

/** What a closure of χ² u costs, and what it weighs: the derivative. */
export const KERNELS = {
  aucun: { rho: (u) => u, weight: () => 1 },
  huber: kernel(1, (d, u) => (u <= d * d ? u : 2 * d * Math.sqrt(u) - d * d), (d, u) => d / Math.sqrt(Math.max(u, d * d))),
  dcs: kernel(
    10,
    (phi, u) => (u <= phi ? u : (phi * (3 * u - phi)) / (u + phi)),
    (phi, u) => Math.min(1, (2 * phi) / (phi + u)) ** 2,
  ),
  commutables: kernel(10, (prior, u) => (prior * u) / (prior + u), (prior, u) => (prior / (prior + u)) ** 2),
};

function kernel(scale, rho, weight) {
  return { scale, rho: (u) => rho(scale, u), weight: (u) => weight(scale, u) };
}

/** Only what joins poses that do not follow each other is doubted. */
export const doubted = ({ i, j }) => Math.abs(i - j) !== 1;

/** What each edge counts for. */
export function weights(edges, chi2, { weight }) {
  return edges.map((edge, k) => (doubted(edge) ? weight(chi2[k]) : 1));
}

/** The sum that is minimised. */
export function cost(edges, chi2, { rho }) {
  return edges.reduce((sum, edge, k) => sum + (doubted(edge) ? rho(chi2[k]) : chi2[k]), 0);
}

/** The poses after one step of Gauss-Newton, those of `fixed` held; one of them at least. */
export function step(edges, poses, kernel, fixed) {
  const place = new Map();
  poses.forEach((_, k) => fixed.includes(k) || place.set(k, 3 * place.size));
  const n = 3 * place.size;
  const [H, b] = [new Float64Array(n * n), new Float64Array(n)];
  const weigh = weights(edges, edgeChi2(edges, poses), kernel);
  edges.forEach((edge, k) => add(H, b, n, edge, poses, place, weigh[k]));
  const change = solved(H, b.map((value) => -value), n);
  return poses.map((pose, k) => {
    const at = place.get(k);
    if (at === undefined) return pose;
    return [pose[0] + change[at], pose[1] + change[at + 1], turned(pose[2] + change[at + 2])];
  });
}

function add(H, b, n, { i, j, z, information }, poses, place, weight) {
  const [c, s] = [Math.cos(poses[i][2]), Math.sin(poses[i][2])];
  const [dx, dy] = [poses[j][0] - poses[i][0], poses[j][1] - poses[i][1]];
  const e = residual(poses[i], poses[j], z);
  const J = [
    [-c, -s, -s * dx + c * dy, c, s, 0],
    [s, -c, -c * dx - s * dy, -s, c, 0],
    [0, 0, -1, 0, 0, 1],
  ];
  const at = [i, i, i, j, j, j].map((pose, k) => (place.has(pose) ? place.get(pose) + (k % 3) : -1));
  for (let k = 0; k < 3; k += 1) {
    const w = weight * information[k];
    for (let p = 0; p < 6; p += 1) {
      if (at[p] < 0) continue;
      b[at[p]] += w * J[k][p] * e[k];
      for (let q = 0; q < 6; q += 1) if (at[q] >= 0) H[at[p] * n + at[q]] += w * J[k][p] * J[k][q];
    }
  }
}

/** The solution of H x = b, H symmetric and definite: Cholesky, in place. */
function solved(H, b, n) {
  for (let j = 0; j < n; j += 1) {
    for (let i = j; i < n; i += 1) {
      let sum = H[i * n + j];
      for (let k = 0; k < j; k += 1) sum -= H[i * n + k] * H[j * n + k];
      H[i * n + j] = i === j ? Math.sqrt(sum) : sum / H[j * n + j];
    }
  }
  for (let i = 0; i < n; i += 1) {
    for (let k = 0; k < i; k += 1) b[i] -= H[i * n + k] * b[k];
    b[i] /= H[i * n + i];
  }
  for (let i = n - 1; i >= 0; i -= 1) {
    for (let k = i + 1; k < n; k += 1) b[i] -= H[k * n + i] * b[k];
    b[i] /= H[i * n + i];
  }
  return b;
}
