"""Sparse symmetric systems: where blocks fall, and LDL' factors that keep what the pattern alone decides.

With `qdldl` the ordering and the elimination tree are worked out once, for the first matrix. Without it SciPy's SuperLU
serves: its minimum degree ordering is kept too, applied to the pattern so that later matrices come already permuted.
Both agree to rounding; qdldl is several times faster.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import linalg as sparse_linalg

from reference.pose_graph.errors import SingularSystemError
from reference.pose_graph.graph import Floats, Indices

try:
    import qdldl
except ImportError:
    qdldl = None

SUPERLU_OPTIONS = {"SymmetricMode": True}
RELATIVE_PIVOT = 1e-13


@dataclass(frozen=True)
class Lower:
    """A[p][:, p] = L D L': `L` (s, s) unit lower triangular, `pivots` (s,) the diagonal of D, `p` (s,) the order."""

    L: sparse.csc_array
    pivots: Floats
    p: Indices


class Factor(Protocol):
    """The factor of a symmetric matrix (s, s)."""

    def update(self, data: Floats) -> None:
        """Factorise another matrix of the same pattern. Raises SingularSystemError."""

    def solve(self, b: Floats) -> Floats:
        """The solution (s,) for a right-hand side (s,)."""

    def lower(self) -> Lower:
        """The factor itself."""


class Pattern:
    """Where the upper triangle of a symmetric matrix of blocks is non-zero; columns one after the other.

    `sizes` (N,): the size of each node's block, 0 for a node that is held fixed. `a`, `b` (p,): the pairs of nodes that
    have a block off the diagonal. Entries that belong to a fixed node go to the slot `nnz`, which is cut off.
    """

    def __init__(self, sizes: Indices, a: Indices, b: Indices) -> None:
        self.sizes = sizes
        self.offsets = np.concatenate([[0], np.cumsum(sizes)])
        self.size = int(self.offsets[-1])
        self._pairs(a, b)
        self._columns()
        self._rows()

    def _pairs(self, a: Indices, b: Indices) -> None:
        """Each distinct block above the diagonal, by columns; `_cell` (p,) says which one each pair falls in."""
        n = len(self.sizes)
        self._a = a
        self._swapped = a > b
        self._alive = (self.sizes[a] > 0) & (self.sizes[b] > 0)
        keys = np.maximum(a, b) * n + np.minimum(a, b)
        cells, inverse = np.unique(keys[self._alive], return_inverse=True)
        self._cell = np.zeros(len(a), dtype=np.int64)
        self._cell[self._alive] = inverse
        self._hi, self._lo = np.divmod(cells, max(n, 1))

    def _columns(self) -> None:
        """`starts` (s + 1,) of the columns; `_above` (N,): entries above the diagonal block; `_rank`: those before."""
        heights = self.sizes[self._lo]
        self._above = np.bincount(self._hi, heights, minlength=len(self.sizes)).astype(np.int64)
        before = np.cumsum(heights) - heights
        self._rank = before - (np.cumsum(self._above) - self._above)[self._hi]
        node = np.repeat(np.arange(len(self.sizes)), self.sizes)
        lengths = self._above[node] + np.arange(self.size) - self.offsets[node] + 1
        self.starts = np.concatenate([[0], np.cumsum(lengths)])
        self.nnz = int(self.starts[-1])

    def _rows(self) -> None:
        """`rows` (nnz,) of the entries."""
        self.rows: NDArray[np.int32 | np.int64] = np.empty(self.nnz + 1, dtype=np.int64)
        deepest = int(self.sizes.max(initial=0))
        for column in range(deepest):
            for row in range(deepest):
                inside = (self.sizes[self._lo] > row) & (self.sizes[self._hi] > column)
                slots = self.starts[self.offsets[self._hi] + column * inside] + self._rank + row
                self.rows[slots[inside]] = (self.offsets[self._lo] + row)[inside]
            for row in range(column + 1):
                self.rows[self.diagonal(row, column)] = self.offsets[:-1] + row
        self.rows = self.rows[:-1].astype(np.int32)
        self.starts = self.starts.astype(np.int32)

    def diagonal(self, row: int, column: int) -> Indices:
        """The slots (N,) of the entry (row, column), row <= column, of the diagonal block of each node."""
        free = self.sizes > column
        slots = self.starts[self.offsets[:-1] + column * free] + self._above + row
        return np.where(free, slots, self.nnz)

    def off_diagonal(self, row: int, column: int) -> Indices:
        """The slots (p,) of the entry (row, column) of the blocks of all pairs; row is that of the first node."""
        if not len(self._hi):
            return np.full(len(self._a), self.nnz, dtype=np.int64)
        inner_row = np.where(self._swapped, column, row)
        inner_column = np.where(self._swapped, row, column)
        at = self.offsets[self._hi[self._cell]] + inner_column
        slots = self.starts[np.minimum(at, self.size)] + self._rank[self._cell] + inner_row
        return np.where(self._alive, slots, self.nnz)

    def unknowns(self, nodes: Indices, component: int) -> Indices:
        """The rows of a component of nodes, `size` for fixed ones."""
        return np.where(self.sizes[nodes] > component, self.offsets[nodes] + component, self.size)

    def upper(self, data: Floats) -> sparse.csc_array:
        """The upper triangle (s, s) whose entries are `data` (nnz,)."""
        return sparse.csc_array((data, self.rows, self.starts), shape=(self.size, self.size))


class QdldlFactor:
    """LDL' by qdldl, whose ordering and elimination tree serve every matrix of the pattern."""

    def __init__(self, upper: sparse.csc_array) -> None:
        self._upper = upper
        try:
            self._solver = qdldl.Solver(upper, upper=True)
        except RuntimeError as error:
            raise _singular(error) from error

    def update(self, data: Floats) -> None:
        self._upper.data = data
        try:
            self._solver.update(self._upper, upper=True)
        except RuntimeError as error:
            raise _singular(error) from error

    def solve(self, b: Floats) -> Floats:
        return np.asarray(self._solver.solve(b))

    def lower(self) -> Lower:
        L, pivots, p = self._solver.factors()
        below = sparse.csc_array(L)
        unit = below + sparse.eye_array(below.shape[0], format="csc")
        return Lower(unit, np.asarray(pivots), np.asarray(p, dtype=np.int64))


class SuperLuFactor:
    """LDL' by SciPy's SuperLU: without pivoting off the diagonal, U = D L'. The order is that of the first matrix."""

    def __init__(self, upper: sparse.csc_array) -> None:
        self._order = _minimum_degree(upper)
        self._pick, self._permuted = _mirrored(upper, self._order)
        self.update(upper.data)

    def update(self, data: Floats) -> None:
        self._permuted.data = data[self._pick]
        self._lu = _superlu(self._permuted, "NATURAL")

    def solve(self, b: Floats) -> Floats:
        x = np.empty_like(b)
        x[self._order] = self._lu.solve(b[self._order])
        return x

    def lower(self) -> Lower:
        again = np.argsort(self._lu.perm_c)
        if not np.array_equal(self._lu.perm_r, self._lu.perm_c):
            raise SingularSystemError("a pivot on the diagonal is zero")
        return Lower(sparse.csc_array(self._lu.L), self._lu.U.diagonal(), self._order[again])


def _superlu(full: sparse.csc_array, ordering: Literal["NATURAL", "MMD_AT_PLUS_A"]) -> sparse_linalg.SuperLU:
    try:
        return sparse_linalg.splu(full, permc_spec=ordering, diag_pivot_thresh=0.0, options=SUPERLU_OPTIONS)
    except RuntimeError as error:
        raise _singular(error) from error


def _minimum_degree(upper: sparse.csc_array) -> Indices:
    """An order (s,) of elimination with little fill, found on a matrix of the same pattern that cannot be singular."""
    pattern = sparse.csc_array((np.ones(upper.nnz), upper.indices, upper.indptr), shape=upper.shape)
    full = pattern + pattern.T
    dominant = full + sparse.diags_array(full.sum(axis=0), format="csc")
    return np.argsort(_superlu(sparse.csc_array(dominant), "MMD_AT_PLUS_A").perm_c).astype(np.int64)


def _mirrored(upper: sparse.csc_array, order: Indices) -> tuple[Indices, sparse.csc_array]:
    """The whole matrix in the given order, and which entry of `upper` each of its entries is."""
    which = sparse.csc_array((np.arange(1, upper.nnz + 1), upper.indices, upper.indptr), shape=upper.shape)
    full = (which + sparse.triu(which, k=1).T).tocsc()[order][:, order].tocsc()
    full.sort_indices()
    pick = full.data.astype(np.int64) - 1
    return pick, sparse.csc_array((upper.data[pick], full.indices, full.indptr), shape=upper.shape)


def _singular(error: RuntimeError) -> SingularSystemError:
    return SingularSystemError(f"the normal equations are singular: {error}")


def factorise(upper: sparse.csc_array) -> Factor:
    """The factor of the symmetric matrix of which `upper` is the upper triangle, its whole diagonal stored."""
    return SuperLuFactor(upper) if qdldl is None else QdldlFactor(upper)


def positive_definite(upper: sparse.csc_array, lower: Lower) -> bool:
    """Is every pivot positive, and more than what rounding leaves of the diagonal entry that it comes from?"""
    return bool(np.all(lower.pivots > RELATIVE_PIVOT * upper.diagonal()[lower.p]))
