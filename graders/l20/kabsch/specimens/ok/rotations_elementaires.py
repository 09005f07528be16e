"""Jacobi's way: turns in one plane after the other, each the best there, until none helps; from several starts."""


def meilleure(H, R):
    d = len(H)
    for _ in range(200):
        mieux = 0.0
        for i in range(d):
            for j in range(i + 1, d):
                A = R @ H  # on veut sa trace la plus grande
                angle = np.arctan2(A[i, j] - A[j, i], A[i, i] + A[j, j])
                G = np.eye(d)
                G[i, i] = G[j, j] = np.cos(angle)
                G[i, j], G[j, i] = -np.sin(angle), np.sin(angle)
                gain = np.trace(G @ A) - np.trace(A)
                if gain < 0 or np.trace(G.T @ A) > np.trace(G @ A):
                    G = G.T
                    gain = np.trace(G @ A) - np.trace(A)
                if gain > 0:
                    R, mieux = G @ R, max(mieux, gain)
        if mieux <= 1e-15 * (1.0 + abs(np.trace(R @ H))):
            break
    return R


def kabsch(P, Q):
    d = P.shape[1]
    H = (P - P.mean(0)).T @ (Q - Q.mean(0))
    departs = [np.eye(d)]
    if d == 3:
        departs += [np.diag(s) for s in ([1, -1, -1], [-1, 1, -1], [-1, -1, 1])]
    R = max((meilleure(H, depart) for depart in departs), key=lambda R: np.trace(R @ H))
    return R, Q.mean(0) - R @ P.mean(0)
