"""Is an optimum global? A proof by duality, read off the signs of the pivots of one sparse factor.

Write positions and landmarks as complex numbers t, rotations as r, |r| = 1. Around an estimate x^ each edge's share of
chi2 has a lower bound that is quadratic in (t, r), and meets it at x^ with the same gradient:

- rotation: with d the error of the angle, |r_j - r_i e^(i theta_z)|^2 = q = 2 (1 - cos d), and d^2 is a convex function
  of q, of slope d / sin d, hence d^2 >= d^^2 + (d^ / sin d^) (q - q^);                                      (18)
- translation: with a = conj(r_i) (t_j - t_i) - z and tau the least eigenvalue of its information,
  tau |a|^2 = tau |t_j - t_i - r_i z|^2, and the rest of the information, positive semidefinite, is convex in e: it is
  bounded by its tangent, linear in a.                                                                      (19)

The sum of these bounds is v' M v + constant, v = (t, r), M hermitian and sparse. With l = Re conj(r^) (M v^) and
S = M - diag(0, l), S v^ = 0 where the gradient of chi2 vanishes, and for every v with |r| = 1

    chi2(v) - chi2(v^) >= v' M v - v^' M v^ = v' S v,                                                       (20)

so S >= 0 proves x^ global, for chi2 itself. S has two null vectors, the translation and v^; without the position and
rotation of one pose it must be positive definite, which its inertia shows: no negative pivot in LDL'. (Eigenvalues by
iterations are no substitute: they have let local minima pass.) The proof is one-sided: where it fails nothing is known.
For information isotropic in translation and small errors of angles, S is the dual matrix of SE-Sync.

Sources: Rosen, Carlone, Bandeira, Leonard, "SE-Sync" (IJRR 2019), theorem 7; Carlone, Calafiore, Tommolillo, Dellaert,
"Planar Pose Graph Optimization: Duality, Optimal Solutions, and Verification" (T-RO 2016). (18), (19) are ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from reference.pose_graph.errors import ParameterError, SingularSystemError
from reference.pose_graph.factor import factorise
from reference.pose_graph.graph import POINT, Floats, Indices, PoseGraph, copy_checked_landmarks, copy_checked_poses
from reference.pose_graph.residuals import landmark_residuals, planar_information, residuals

Complex = NDArray[np.complex128]
STATIONARY = 1e-6
NEARLY_NONE = 1e-12


@dataclass(frozen=True)
class Certificate:
    """`is_global`: proven to be a global minimum of chi2; otherwise nothing is proven.

    `negative_pivots`: how many pivots of S, as a real matrix, are not positive. `gradient`: the norm of S v^ relative
    to that of M v^, near 0 at a stationary point.
    """

    is_global: bool
    negative_pivots: int
    gradient: float


class _MatrixTerms(NamedTuple):
    """Entries of the hermitian matrix M above or below its diagonal, each given once, and those on it."""

    rows: Indices
    columns: Indices
    values: Complex | Floats


def certify(graph: PoseGraph, poses: ArrayLike, landmarks: ArrayLike | None = None) -> Certificate:
    """Try to prove that poses (n, 3) and landmarks (l, 2), where an optimiser stopped, are a global minimum of chi2.

    Nothing is proven where edges have partial information: (18) and (19) need all of it.
    Raises a PoseGraphError for arguments that do not fit the graph, ParameterError where several poses are fixed.
    """
    if len(graph.fixed) > 1:
        raise ParameterError("graph", "several poses are fixed: the proof is for one")
    where, seen_at = copy_checked_poses(graph, poses), copy_checked_landmarks(graph, landmarks)
    v = np.concatenate([where[:, 0] + 1j * where[:, 1], seen_at[:, 0] + 1j * seen_at[:, 1], np.exp(1j * where[:, 2])])
    if graph.n_poses + graph.n_landmarks == 1:
        return Certificate(True, 0, 0.0)
    if not graph.is_fully_informed:
        return Certificate(False, len(v), np.inf)
    edges, sightings = _edge_terms(graph, where), _sighting_terms(graph, where, seen_at)
    if edges is None:
        return Certificate(False, len(v), np.inf)
    S, gradient = _dual_matrix(_assemble_hermitian([*edges, *sightings], len(v)), v, graph.n_poses + graph.n_landmarks)
    negative = _count_non_positive_pivots(S, [graph.fixed[0], graph.n_poses + graph.n_landmarks + graph.fixed[0]])
    return Certificate(negative == 0 and gradient < STATIONARY, negative, gradient)


def _edge_terms(graph: PoseGraph, poses: Floats) -> list[_MatrixTerms] | None:
    """The bounds (18) and (19) of the edges; None where an angle is so wrong that (18) has no tangent."""
    i, j, z, omega = graph.i, graph.j, graph.z_i_j, planar_information(graph).to_matrices()
    e = residuals(poses[i], poses[j], z)
    tau = _least_eigenvalues(omega[:, :2, :2])
    kappa = omega[:, 2, 2].copy()
    shrink = _separable_factors(omega, tau, kappa)
    tau, kappa = tau * shrink, kappa * shrink
    rest = omega.copy()
    rest[:, [0, 1, 2], [0, 1, 2]] -= np.stack([tau, tau, kappa], axis=1)
    slope = np.einsum("mab,mb->ma", rest, e)  # half the gradient of e' rest e
    shift = slope[:, 2] / kappa  # kappa d^2 + 2 k d = kappa (d + k / kappa)^2 - constant
    turn = e[:, 2] + shift
    if np.any(np.abs(turn) >= np.pi):
        return None
    kappa /= np.sinc(turn / np.pi)  # numpy's sinc(x) is sin(pi x) / (pi x)
    measured = np.exp(1j * (z[:, 2] - shift))
    ri, rj = (ends + graph.n_poses + graph.n_landmarks for ends in (i, j))
    translation = _translation_terms(i, j, ri, z[:, 0] + 1j * z[:, 1], tau, slope[:, 0] + 1j * slope[:, 1])
    return [
        *translation,
        _MatrixTerms(ri, ri, kappa),
        _MatrixTerms(rj, rj, kappa),
        _MatrixTerms(ri, rj, -kappa / measured),
    ]


def _separable_factors(omega: Floats, tau: Floats, kappa: Floats) -> Floats:
    """The largest factors s (m,) <= 1 with omega >= s diag(tau, tau, kappa): 1 without coupling."""
    root = 1.0 / np.sqrt(np.stack([tau, tau, kappa], axis=1))
    scaled = omega * root[:, :, None] * root[:, None, :]
    return np.minimum(1.0, _least_eigenvalues(scaled) * (1.0 + NEARLY_NONE))


def _least_eigenvalues(matrices: Floats) -> Floats:
    """The least eigenvalues (m,) of symmetric matrices (m, s, s)."""
    return np.asarray(np.linalg.eigvalsh(matrices)[:, 0], dtype=np.float64)


def _sighting_terms(graph: PoseGraph, poses: Floats, landmarks: Floats) -> list[_MatrixTerms]:
    """The bounds (19) of the sightings."""
    seen = graph.sightings
    e = landmark_residuals(poses[seen.i], landmarks[seen.landmark], seen.p_i_l)
    tau = _least_eigenvalues(seen.information)
    slope = np.einsum("mab,mb->ma", seen.information - tau[:, None, None] * np.eye(POINT), e)
    z, gamma = (a[:, 0] + 1j * a[:, 1] for a in (seen.p_i_l, slope))
    ri = seen.i + graph.n_poses + graph.n_landmarks
    return _translation_terms(seen.i, seen.landmark + graph.n_poses, ri, z, tau, gamma)


def _translation_terms(
    i: Indices, j: Indices, ri: Indices, z: Complex, tau: Floats, gamma: Complex
) -> list[_MatrixTerms]:
    """tau |t_j - t_i - r_i z|^2 + 2 Re(conj(gamma) a), the tangent of (19) being 2 gamma . a up to a constant."""
    across = gamma.conj() - tau * z.conj()
    return [
        _MatrixTerms(i, i, tau),
        _MatrixTerms(j, j, tau),
        _MatrixTerms(ri, ri, tau * np.abs(z) ** 2),
        _MatrixTerms(i, j, -tau),
        _MatrixTerms(ri, j, across),
        _MatrixTerms(ri, i, -across),
    ]


def _assemble_hermitian(terms: list[_MatrixTerms], size: int) -> sparse.csr_array:
    """M from its terms: what is off the diagonal gets its conjugate on the other side."""
    rows, columns, values = (np.concatenate(part) for part in zip(*terms, strict=True))
    off = rows != columns
    every_row, every_column = np.concatenate([rows, columns[off]]), np.concatenate([columns, rows[off]])
    every_value = np.concatenate([values, values[off].conj()])
    return sparse.coo_array((every_value, (every_row, every_column)), shape=(size, size)).tocsr()


def _dual_matrix(M: sparse.csr_array, v: Complex, first_rotation: int) -> tuple[sparse.csr_array, float]:
    """S of (20), and how far S v is from 0."""
    product = np.asarray(M @ v)
    multipliers = (v.conj() * product).real
    multipliers[:first_rotation] = 0.0
    left = product - multipliers * v
    scale = np.asarray(abs(M) @ np.abs(v))
    S = sparse.csr_array(M - sparse.diags_array(multipliers))
    return S, float(np.linalg.norm(left) / np.linalg.norm(scale))


def _count_non_positive_pivots(S: sparse.csr_array, without: list[int]) -> int:
    """How many pivots of the real form of S are not positive, the rows and columns `without` left out.

    a + ib is the real block [[a, -b], [b, a]].
    """
    kept = np.setdiff1d(np.arange(S.shape[0]), without)
    inner = S[kept][:, kept]
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    real = sparse.kron(inner.real, np.eye(POINT), format="csc") + sparse.kron(inner.imag, turn, format="csc")
    upper = sparse.csc_array(sparse.triu(real, format="csc"))
    try:
        pivots = factorise(upper).lower().pivots
    except SingularSystemError:
        return 1
    return int(np.count_nonzero(pivots <= 0.0))
