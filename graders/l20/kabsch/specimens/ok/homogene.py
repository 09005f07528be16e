"""Homogeneous matrices: back to the centre, turn, away to the other centre."""


def deplacement(v):
    M = np.eye(len(v) + 1)
    M[:-1, -1] = v
    return M


def kabsch(P, Q):
    d = P.shape[1]
    p, q = np.average(P, axis=0), np.average(Q, axis=0)
    un = np.ones((len(P), 1))
    croisee = np.hstack([P, un]).T @ np.hstack([Q, un]) / len(P) - np.outer([*p, 1], [*q, 1])
    U, _, Vt = np.linalg.svd(croisee[:d, :d])
    tourne = np.eye(d + 1)
    tourne[:d, :d] = Vt.T @ np.diag(np.append(np.ones(d - 1), np.linalg.slogdet(U @ Vt)[0])) @ U.T
    M = deplacement(q) @ tourne @ deplacement(-p)
    return M[:d, :d], M[:d, d]
