"""The two files that a student might hand in, and how long each computes by its own account."""

from __future__ import annotations

from dataclasses import dataclass

#: What is added to a file so that it tells its own computing time: its top level, then its last call.
TIMED = """
import time as _time
_began = _time.perf_counter()
{source}
_loaded = _time.perf_counter() - _began

def timed(*arguments):
    began = _time.perf_counter()
    answer = {function}(*arguments)
    return answer, _loaded + _time.perf_counter() - began
"""

COMPOSER = """
import numpy as np

def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]])
"""

GAUSS_NEWTON = """
import numpy as np
import scipy.sparse
import scipy.sparse.linalg

def gauss_newton(mesures):
    n = len(mesures)
    depart, arrivee = np.arange(n), (np.arange(n) + 1) % n
    poses = np.zeros((n, 3))
    for i in range(1, n):
        c, s = np.cos(poses[i - 1, 2]), np.sin(poses[i - 1, 2])
        x, y, t = mesures[i - 1]
        poses[i] = poses[i - 1] + [c * x - s * y, s * x + c * y, t]
    for _ in range(5):
        d, theta = poses[arrivee] - poses[depart], poses[depart, 2]
        c, s = np.cos(theta), np.sin(theta)
        erreur = np.stack([c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0], d[:, 2]], axis=1) - mesures
        erreur[:, 2] = (erreur[:, 2] + np.pi) % (2 * np.pi) - np.pi
        bloc = np.zeros((n, 3, 6))
        bloc[:, 0, 3], bloc[:, 0, 4], bloc[:, 1, 3], bloc[:, 1, 4] = c, s, -s, c
        bloc[:, 2, 5] = 1
        bloc[:, :, :3] = -bloc[:, :, 3:]
        bloc[:, 0, 2] = -s * d[:, 0] + c * d[:, 1]
        bloc[:, 1, 2] = -s * d[:, 1] - c * d[:, 0]
        lignes = np.broadcast_to((3 * np.arange(n)[:, None] + np.arange(3))[:, :, None], bloc.shape)
        trois = np.arange(3)
        colonnes = np.concatenate([3 * depart[:, None] + trois, 3 * arrivee[:, None] + trois], axis=1)[:, None, :]
        colonnes = np.broadcast_to(colonnes, bloc.shape)
        j = scipy.sparse.coo_matrix((bloc.ravel(), (lignes.ravel(), colonnes.ravel())), shape=(3 * n, 3 * n)).tocsc()
        h = (j.T @ j + 1e6 * scipy.sparse.diags((np.arange(3 * n) < 3).astype(float))).tocsc()
        poses -= scipy.sparse.linalg.spsolve(h, j.T @ erreur.ravel()).reshape(n, 3)
    return poses
"""


@dataclass(frozen=True)
class Program:
    """A file, its function, and Python expressions for the argument(s) and for what must hold of the `answer`."""

    name: str
    source: str
    function: str
    arguments: str
    holds: str

    @property
    def timed(self) -> bytes:
        return TIMED.format(source=self.source, function=self.function).encode()

    @property
    def test(self) -> str:
        """Lines that call the function and check its answer, for the peers."""
        return f"import numpy as np\nanswer = {self.function}({self.arguments})\nassert {self.holds}\n"


PROGRAMS = (
    Program(
        "`composer`, numpy",
        COMPOSER,
        "composer",
        "np.array([1.0, 2.0, 0.5]), np.array([1.0, 0.0, 0.25])",
        "abs(answer[2] - 0.75) < 1e-12",
    ),
    Program(
        "Gauss-Newton, scipy.sparse",
        GAUSS_NEWTON,
        "gauss_newton",
        "np.column_stack([np.ones(60), 0.01 * np.sin(np.arange(60)), np.full(60, 0.105)])",
        "abs(answer[30, 2] - 30 * 2 * np.pi / 60) < 0.01",
    ),
)
