"""A generator of states, of which the last is kept; a dictionary of votes for nothing."""
from itertools import islice


def etats(P, Q, R, t):
    while True:
        B = Q[[int(np.argmin((Q[:, 0] - x) ** 2 + (Q[:, 1] - y) ** 2)) for x, y in (R @ P.T).T + t]]
        moyenne = np.stack([P, B]).mean(axis=1)
        H = np.einsum("ni,nj->ij", P - moyenne[0], B - moyenne[1])
        U, _, Vt = np.linalg.svd(H)
        R = Vt.T @ np.diag([1.0, np.linalg.det(U) * np.linalg.det(Vt)]) @ U.T
        t = moyenne[1] - R @ moyenne[0]
        yield R, t, float(np.sum((P @ R.T + t - B) ** 2))


def icp(source, cible, rotation, translation, combien=30):
    tous = list(islice(etats(source, cible, rotation, translation), combien))
    return tous[-1][0], tous[-1][1], [e for _, _, e in tous]
