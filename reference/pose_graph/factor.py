"""Sparse symmetric systems: where blocks fall, and LDL' factors that keep what the pattern alone decides.

With `qdldl` the ordering and the elimination tree are worked out once, for the first matrix. Without it SciPy's SuperLU
serves: its minimum degree ordering is kept too, applied to the pattern so that later matrices come already permuted.
Both agree to rounding; qdldl is several times faster.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from scipy import sparse
from scipy.sparse import linalg as sparse_linalg

from reference.pose_graph.errors import SingularSystemError
from reference.pose_graph.graph import BLOCK, Floats, Indices

try:
    import qdldl
except ImportError:
    qdldl = None

SUPERLU_OPTIONS = {"SymmetricMode": True}
RELATIVE_PIVOT = 1e-13


@dataclass(frozen=True)
class LowerFactor:
    """A[p][:, p] = L D L': `L` (s, s) unit lower triangular, `pivots` (s,) the diagonal of D, `p` (s,) the order."""

    L: sparse.csc_array
    pivots: Floats
    p: Indices


class Factorisation(Protocol):
    """The factor of a symmetric matrix (s, s)."""

    def update(self, data: Floats) -> None:
        """Factorise another matrix of the same pattern. Raises SingularSystemError."""

    def solve(self, b: Floats) -> Floats:
        """The solution (s,) for a right-hand side (s,)."""

    def lower(self) -> LowerFactor:
        """The factor itself."""


class SparsityPattern:
    """Where the upper triangle of a symmetric matrix of blocks is non-zero; columns one after the other.

    `sizes` (N,): the size of each node's block, 0 for a node that is held fixed. `a`, `b` (p,): the pairs of nodes that
    have a block off the diagonal. What is in no block, or below the diagonal, goes to the slot `nnz`, which is cut off.
    """

    def __init__(self, sizes: Indices, a: Indices, b: Indices) -> None:
        self.sizes = sizes
        self.offsets = np.concatenate([[0], np.cumsum(sizes)])
        self.size = int(self.offsets[-1])
        self._index_block_pairs(a, b)
        self._index_columns()
        self._index_rows()

    def _index_block_pairs(self, a: Indices, b: Indices) -> None:
        """Each distinct block above the diagonal, by columns; `_cell` (p,) says which one each pair falls in."""
        n = len(self.sizes)
        self._a, self._b = a, b
        self._swapped = a > b
        alive = (self.sizes[a] > 0) & (self.sizes[b] > 0)
        keys = np.maximum(a, b) * n + np.minimum(a, b)
        cells, inverse = np.unique(keys[alive], return_inverse=True)
        self._cell = np.zeros(len(a), dtype=np.int64)
        self._cell[alive] = inverse
        self._hi, self._lo = np.divmod(cells, max(n, 1))

    def _index_columns(self) -> None:
        """`starts` (s + 1,) of the columns; for each node, the `_first` of them, and how many entries are `_above`.

        Column c of a node holds the rows above its block, then c + 1 of its own: c columns before it hold
        c above + c (c + 1) / 2 entries. `_rank`: those above the block of a pair, in a column.
        """
        heights = self.sizes[self._lo]
        self._above = np.bincount(self._hi, heights, minlength=len(self.sizes)).astype(np.int64)
        component = np.arange(self.size) - self.offsets[:-1].repeat(self.sizes)
        self.starts = np.concatenate([[0], np.cumsum(self._above.repeat(self.sizes) + component + 1)])
        self.nnz = int(self.starts[-1])
        self._first = self.starts[self.offsets[:-1]]
        before = np.cumsum(heights) - heights
        self._rank = before - (np.cumsum(self._above) - self._above)[self._hi]

    def _index_rows(self) -> None:
        """`rows` (nnz,) of the entries: those of the nodes above each node and its own, cut at the diagonal."""
        n = len(self.sizes)
        stacked = np.empty(len(self._lo) + n, dtype=np.int64)
        stacked[np.arange(len(self._lo)) + self._hi] = self._lo
        ends = np.bincount(self._hi, minlength=n).cumsum() + np.arange(n)
        stacked[ends] = np.arange(n)
        heights = self.sizes[stacked]
        tops = np.cumsum(heights) - heights
        unknowns = (self.offsets[stacked] - tops).repeat(heights) + np.arange(heights.sum())
        top = (tops[ends] - self._above).repeat(self.sizes)
        lengths = np.diff(self.starts)
        self.rows = unknowns[(top - self.starts[:-1]).repeat(lengths) + np.arange(self.nnz)].astype(np.int32)
        self.starts = self.starts.astype(np.int32)

    def diagonal_slots(self) -> Indices:
        """The slots [row, column, node] of the entries of the diagonal blocks, where row <= column."""
        row, column = self._block_offsets()
        slots = self._first + self._above * (column + 1) + (column * (column + 1) // 2 + row)
        return np.where((row <= column) & (self.sizes > column), slots, self.nnz)

    def off_diagonal_slots(self) -> Indices:
        """The slots [row, column, pair] of the entries of the blocks of pairs; row is that of the first node."""
        row, column = self._block_offsets()
        if not len(self._hi):
            return np.full((len(row), len(row), len(self._a)), self.nnz)
        above, first = self._above[self._hi], self._first[self._hi] + self._rank
        below = (first[self._cell] + column * above[self._cell]) + (column * (column + 1) // 2 + row)
        if self._swapped.any():
            below = np.where(self._swapped, below.swapaxes(0, 1), below)
        return np.where((self.sizes[self._a] > row) & (self.sizes[self._b] > column), below, self.nnz)

    def _block_offsets(self) -> tuple[Indices, Indices]:
        """The rows (3, 1, 1) and the columns (3, 1) of a block, as large as any may be."""
        inner = np.arange(BLOCK)[:, None]
        return inner[:, None], inner

    def unknowns_of_nodes(self, nodes: Indices) -> Indices:
        """The rows [component, node] of nodes (k,), `size` for what they have not."""
        component, _ = self._block_offsets()
        return np.where(self.sizes[nodes] > component[:, 0], self.offsets[nodes] + component[:, 0], self.size)

    def upper_triangle(self, data: Floats) -> sparse.csc_array:
        """The upper triangle (s, s) whose entries are `data` (nnz,)."""
        return sparse.csc_array((data, self.rows, self.starts), shape=(self.size, self.size))


class QdldlFactor:
    """LDL' by qdldl, whose ordering and elimination tree serve every matrix of the pattern."""

    def __init__(self, upper: sparse.csc_array) -> None:
        # of the class that the library knows: another is converted each time
        self._upper = sparse.csc_matrix(upper)
        try:
            self._solver = qdldl.Solver(self._upper, upper=True)
        except RuntimeError as error:
            raise _to_singular_error(error) from error

    def update(self, data: Floats) -> None:
        self._upper.data = data
        try:
            self._solver.update(self._upper, upper=True)
        except RuntimeError as error:
            raise _to_singular_error(error) from error

    def solve(self, b: Floats) -> Floats:
        return np.asarray(self._solver.solve(b))

    def lower(self) -> LowerFactor:
        L, pivots, p = self._solver.factors()
        below = sparse.csc_array(L)
        unit = below + sparse.eye_array(below.shape[0], format="csc")
        return LowerFactor(unit, np.asarray(pivots), np.asarray(p, dtype=np.int64))


class SuperLuFactor:
    """LDL' by SciPy's SuperLU: without pivoting off the diagonal, U = D L'. The order is that of the first matrix."""

    def __init__(self, upper: sparse.csc_array) -> None:
        self._order = _minimum_degree_order(upper)
        self._pick, self._permuted = _mirror_and_permute(upper, self._order)
        self.update(upper.data)

    def update(self, data: Floats) -> None:
        self._permuted.data = data[self._pick]
        self._lu = _factorise_superlu(self._permuted, "NATURAL")

    def solve(self, b: Floats) -> Floats:
        x = np.empty_like(b)
        x[self._order] = self._lu.solve(b[self._order])
        return x

    def lower(self) -> LowerFactor:
        again = np.argsort(self._lu.perm_c)
        if not np.array_equal(self._lu.perm_r, self._lu.perm_c):
            raise SingularSystemError("a pivot on the diagonal is zero")
        return LowerFactor(sparse.csc_array(self._lu.L), self._lu.U.diagonal(), self._order[again])


def _factorise_superlu(full: sparse.csc_array, ordering: Literal["NATURAL", "MMD_AT_PLUS_A"]) -> sparse_linalg.SuperLU:
    try:
        return sparse_linalg.splu(full, permc_spec=ordering, diag_pivot_thresh=0.0, options=SUPERLU_OPTIONS)
    except RuntimeError as error:
        raise _to_singular_error(error) from error


def _minimum_degree_order(upper: sparse.csc_array) -> Indices:
    """An order (s,) of elimination with little fill, found on a matrix of the same pattern that cannot be singular."""
    pattern = sparse.csc_array((np.ones(upper.nnz), upper.indices, upper.indptr), shape=upper.shape)
    full = pattern + pattern.T
    dominant = full + sparse.diags_array(full.sum(axis=0), format="csc")
    return np.argsort(_factorise_superlu(sparse.csc_array(dominant), "MMD_AT_PLUS_A").perm_c).astype(np.int64)


def _mirror_and_permute(upper: sparse.csc_array, order: Indices) -> tuple[Indices, sparse.csc_array]:
    """The whole matrix in the given order, and which entry of `upper` each of its entries is."""
    which = sparse.csc_array((np.arange(1, upper.nnz + 1), upper.indices, upper.indptr), shape=upper.shape)
    full = (which + sparse.triu(which, k=1).T).tocsc()[order][:, order].tocsc()
    full.sort_indices()
    pick = full.data.astype(np.int64) - 1
    return pick, sparse.csc_array((upper.data[pick], full.indices, full.indptr), shape=upper.shape)


def _to_singular_error(error: RuntimeError) -> SingularSystemError:
    return SingularSystemError(f"the normal equations are singular: {error}")


def factorise(upper: sparse.csc_array) -> Factorisation:
    """The factor of the symmetric matrix of which `upper` is the upper triangle, its whole diagonal stored."""
    return SuperLuFactor(upper) if qdldl is None else QdldlFactor(upper)


def is_positive_definite(upper: sparse.csc_array, lower: LowerFactor) -> bool:
    """Is every pivot positive, and more than what rounding leaves of the diagonal entry that it comes from?"""
    return bool(np.all(lower.pivots > RELATIVE_PIVOT * upper.diagonal()[lower.p]))
