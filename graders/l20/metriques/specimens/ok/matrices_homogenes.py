"""Homogeneous matrices, inverted by numpy; Sturm's formula to the letter."""


def T(pose):
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([[c, -s, pose[0]], [s, c, pose[1]], [0, 0, 1]])


def ate(estimees, verite):
    P, Q = estimees[:, :2].T, verite[:, :2].T
    pc, qc = P.mean(1, keepdims=True), Q.mean(1, keepdims=True)
    W = (Q - qc) @ (P - pc).T
    U, _, Vt = np.linalg.svd(W)
    S = np.eye(2)
    if np.linalg.det(U) * np.linalg.det(Vt) < 0:
        S[1, 1] = -1
    R = U @ S @ Vt
    erreur = R @ P + (qc - R @ pc) - Q
    return np.sqrt((erreur**2).sum(0).mean())


def rpe(estimees, verite, delta):
    inv = np.linalg.inv
    P, Q = [T(x) for x in estimees], [T(x) for x in verite]
    erreurs = [
        inv(inv(Q[i]) @ Q[i + delta]) @ (inv(P[i]) @ P[i + delta]) for i in range(len(P) - delta)
    ]
    return np.sqrt(np.mean([np.linalg.norm(E[:2, 2]) ** 2 for E in erreurs]))
