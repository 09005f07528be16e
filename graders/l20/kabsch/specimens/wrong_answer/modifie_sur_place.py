"""Right values, but both clouds are centred in place."""


def kabsch(P, Q):
    p, q = P.mean(axis=0), Q.mean(axis=0)
    P -= p
    Q -= q
    U, _, Vt = np.linalg.svd(P.T @ Q)
    D = np.diag([1.0] * (len(U) - 1) + [np.sign(np.linalg.det(U @ Vt))])
    R = Vt.T @ D @ U.T
    return R, q - R @ p
