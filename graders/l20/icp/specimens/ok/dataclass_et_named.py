"""A dataclass for the motion, composed with @; a named tuple comes back."""
from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True)
class Rigide:
    R: np.ndarray
    t: np.ndarray

    def __matmul__(self, autre):
        return Rigide(self.R @ autre.R, self.R @ autre.t + self.t)

    def __call__(self, X):
        return X @ self.R.T + self.t


class Resultat(NamedTuple):
    R: np.ndarray
    t: np.ndarray
    erreurs: list


def meilleur(A, B):
    U, _, Vt = np.linalg.svd((B - B.mean(0)).T @ (A - A.mean(0)))
    R = U @ np.diag([1, np.sign(np.linalg.det(U @ Vt))]) @ Vt
    return Rigide(R, B.mean(0) - R @ A.mean(0))


def icp(P, Q, R0, t0, n_iter=30):
    g, erreurs = Rigide(np.asarray(R0), np.asarray(t0)), []
    while len(erreurs) < n_iter:
        A = g(P)
        B = Q[[np.abs((Q - a) @ [1, 1j]).argmin() for a in A]]
        erreurs.append(np.sum((A - B) ** 2))
        g = meilleur(A, B) @ g
    return tuple(Resultat(g.R, g.t, erreurs))
