"""Symmetric matrices of (x, y, theta) that turn with the plane: information, as numbers that a rotation multiplies.

Vectors of the plane are numbers x + i y, which turn by one product. So does a symmetric matrix of the plane, once its
trace is set apart: it takes z to p z + q conj(z), with p half its trace, and Q = [[W, k], [k', w]] takes (z, phi) to

    (p z + q conj(z) + k phi,  Re(conj(k) z) + w phi);   turned by u = exp(i theta), it has q u^2, k u          (6)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference.pose_graph.graph import Floats

Complexes = NDArray[np.complex128]


class PlanarMatrices(NamedTuple):
    """The m matrices [[p + Re q, Im q, Re k], [Im q, p - Re q, Im k], [Re k, Im k, w]]: every array is (m,)."""

    p: Floats
    q: Complexes
    k: Complexes
    w: Floats

    @classmethod
    def from_matrices(cls, matrices: Floats) -> PlanarMatrices:
        """From symmetric matrices (m, 3, 3), or (m, 2, 2), which say nothing of the angle."""
        w00, w01, w11 = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 1]
        p, q = (w00 + w11) / 2.0, (w00 - w11) / 2.0 + 1j * w01
        if matrices.shape[1] == 2:
            return cls(p, q, np.zeros_like(q), np.zeros_like(p))
        return cls(p, q, matrices[:, 0, 2] + 1j * matrices[:, 1, 2], matrices[:, 2, 2].copy())

    def rotate(self, u: Complexes) -> PlanarMatrices:
        """P Q P' with P = diag(R(theta), 1), u = exp(i theta) (m,)."""
        return PlanarMatrices(self.p, self.q * (u * u), self.k * u, self.w)

    def scale(self, factors: Floats) -> PlanarMatrices:
        """Each matrix times its factor (m,)."""
        return PlanarMatrices(self.p * factors, self.q * factors, self.k * factors, self.w * factors)

    def multiply(self, z: Complexes, phi: Floats) -> tuple[Complexes, Floats]:
        """The products (6) with vectors (z, phi), (m,) each."""
        return self.p * z + self.q * z.conj() + self.k * phi, (self.k.conj() * z).real + self.w * phi

    def to_matrices(self) -> Floats:
        """The matrices (m, 3, 3)."""
        (qx, qy), (kx, ky) = ((part.real, part.imag) for part in (self.q, self.k))
        rows = [self.p + qx, qy, kx, qy, self.p - qx, ky, kx, ky, self.w]
        return np.stack(rows, axis=-1).reshape(-1, 3, 3)
