"""The error after pairing anew, n_iter + 1 of them: start included."""
def apparier(P, Q, R, t):
    d = np.linalg.norm((P @ R.T + t)[:, None, :] - Q[None, :, :], axis=-1)
    j = d.argmin(axis=1)
    return j, float((d[np.arange(len(P)), j] ** 2).sum())


def icp(P, Q, R0, t0, n_iter=30):
    R, t = R0, t0
    j, e = apparier(P, Q, R, t)
    suite = [e]
    for _ in range(n_iter):
        p, q = P.mean(0), Q[j].mean(0)
        U, _, Vt = np.linalg.svd((P - p).T @ (Q[j] - q))
        if np.linalg.det(U @ Vt) < 0:
            U[:, -1] *= -1
        R = (U @ Vt).T
        t = q - R @ p
        j, e = apparier(P, Q, R, t)
        suite.append(e)
    return R, t, suite
