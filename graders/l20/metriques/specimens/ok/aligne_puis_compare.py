"""The truth is laid over the estimate, and the whole estimate is aligned before its motions are compared."""


def kabsch(P, Q):
    p, q = P.mean(axis=0), Q.mean(axis=0)
    U, _, Vt = np.linalg.svd((P - p).T @ (Q - q))
    R = Vt.T @ U.T
    if np.linalg.det(R) < 0:
        Vt[-1] *= -1
        R = Vt.T @ U.T
    return R, q - R @ p


def ate(estimees, verite):
    R, t = kabsch(verite[:, :2], estimees[:, :2])
    distances = np.linalg.norm(verite[:, :2] @ R.T + t - estimees[:, :2], axis=1)
    return np.sqrt(np.mean(distances**2))


def relatif(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    R = np.array([[c, -s], [s, c]])
    return np.append(R.T @ (b[:2] - a[:2]), b[2] - a[2])


def rpe(estimees, verite, delta):
    R, t = kabsch(estimees[:, :2], verite[:, :2])
    angle = np.arctan2(R[1, 0], R[0, 0])
    alignees = np.column_stack([estimees[:, :2] @ R.T + t, estimees[:, 2] + angle])
    carres = [
        np.sum((relatif(alignees[i], alignees[i + delta])[:2] - relatif(verite[i], verite[i + delta])[:2]) ** 2)
        for i in range(len(verite) - delta)
    ]
    return np.sqrt(sum(carres) / len(carres))
