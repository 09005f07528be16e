"""In the plane, the angle of the sums of dot and cross products; in space, the SVD."""


def kabsch(P, Q):
    p, q = P - P.mean(axis=0), Q - Q.mean(axis=0)
    if P.shape[1] == 2:
        angle = np.arctan2(np.sum(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]), np.sum(p * q))
        c, s = np.cos(angle), np.sin(angle)
        R = np.array([[c, -s], [s, c]])
    else:
        U, _, Vt = np.linalg.svd(p.T @ q)
        troisieme = np.cross(U[:, 0], U[:, 1])
        autre = np.cross(Vt[0], Vt[1])
        R = np.outer(Vt[0], U[:, 0]) + np.outer(Vt[1], U[:, 1]) + np.outer(autre, troisieme)
    return R, Q.mean(axis=0) - R @ P.mean(axis=0)
