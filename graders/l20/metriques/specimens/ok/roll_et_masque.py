"""np.roll and a mask that drops the pairs that go round; a dictionary of means."""


def ate(estimees, verite):
    moy = {"p": estimees.mean(axis=0)[:2], "q": verite.mean(axis=0)[:2]}
    H = sum(np.outer(p[:2] - moy["p"], q[:2] - moy["q"]) for p, q in zip(estimees, verite))
    U, S, V = np.linalg.svd(H)
    d = np.linalg.det(V.T.dot(U.T))
    R = V.T.dot(np.diag((1, round(d)))).dot(U.T)
    t = moy["q"] - R.dot(moy["p"])
    somme = 0
    for k in range(len(verite)):
        somme += np.linalg.norm(R.dot(estimees[k, :2]) + t - verite[k, :2]) ** 2
    return np.sqrt(somme / len(verite))


def rpe(estimees, verite, delta):
    garde = np.arange(len(verite)) < len(verite) - delta
    def local(X):
        D = np.roll(X, -delta, axis=0) - X
        c, s = np.cos(X[:, 2]), np.sin(X[:, 2])
        return np.stack([c * D[:, 0] + s * D[:, 1], -s * D[:, 0] + c * D[:, 1]], axis=1)[garde]
    return float(np.sqrt(np.mean(((local(estimees) - local(verite)) ** 2).sum(axis=1))))
