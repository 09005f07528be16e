"""An explicit stack of hypotheses instead of recursion, and Schur's complement for each pair added."""
from scipy.special import gammaincinv


def seuil(niveau, paires):
    return 2 * gammaincinv(paires, niveau)


def distances2(z, amers, S):
    D = np.zeros((len(z), len(amers)))
    for k in range(len(amers)):
        det = S[k, 0, 0] * S[k, 1, 1] - S[k, 0, 1] * S[k, 1, 0]
        W = np.array([[S[k, 1, 1], -S[k, 0, 1]], [-S[k, 1, 0], S[k, 0, 0]]]) / det
        D[:, k] = [e.dot(W).dot(e) for e in z - amers[k]]
    return D


def associer(z, amers, S, niveau=0.99):
    D = distances2(z, amers, S)
    choix, pris = [-1 for _ in range(len(z))], [False] * len(amers)
    for d in np.unique(D):
        for i, k in zip(*np.where(D == d)):
            if d <= seuil(niveau, 1) and choix[i] == -1 and not pris[k]:
                choix[i], pris[k] = int(k), True
    return tuple(choix)


def nouveaux(z, amers, S, niveau=0.99):
    D = distances2(z, amers, S)
    i, sortie = 0, []
    while i < len(z):
        if np.sum(D[i] < seuil(niveau, 1)) == 0:
            sortie.append(i)
        i += 1
    return np.array(sortie, dtype=int)


def associer_ensemble(z, amers, C, R, niveau=0.99):
    pile = [((), 0.0)]
    meilleure, clef = (-1,) * len(z), (0, 0.0)
    while pile:
        H, d = pile.pop()
        if len(H) == len(z):
            n = sum(k >= 0 for k in H)
            if n and (-n, d) < clef:
                meilleure, clef = H, (-n, d)
            continue
        pile.append(((*H, -1), d))
        i = len(H)
        for k in range(len(amers)):
            if k in H:
                continue
            avant = [(j, q) for j, q in enumerate(H) if q >= 0]
            e, P = z[i] - amers[k], C[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] + R
            if avant:
                r = [2 * q + c for _, q in avant for c in (0, 1)]
                M = C[np.ix_(r, r)] + np.kron(np.eye(len(avant)), R)
                K = np.linalg.solve(M, C[np.ix_(r, [2 * k, 2 * k + 1])]).T
                e = e - K @ np.concatenate([z[j] - amers[q] for j, q in avant])
                P = P - K @ C[np.ix_(r, [2 * k, 2 * k + 1])]
            nouveau = d + e @ np.linalg.solve(P, e)
            if nouveau <= seuil(niveau, len(avant) + 1):
                pile.append(((*H, k), nouveau))
    return list(meilleure)
