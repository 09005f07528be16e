"""Sums written out, point by point; numpy for the decomposition alone; other parameter names."""


def moyenne(points):
    n = len(points)
    total = [0.0] * len(points[0])
    for point in points:
        for k, x in enumerate(point):
            total[k] += x
    return [x / n for x in total]


def kabsch(avant, apres):
    a, b = moyenne(avant), moyenne(apres)
    d = len(a)
    M = np.zeros((d, d))
    for p, q in zip(avant, apres):
        for i in range(d):
            for j in range(d):
                M[i, j] += (q[i] - b[i]) * (p[j] - a[j])
    gauche, _, droite = np.linalg.svd(M)
    if np.linalg.det(gauche) * np.linalg.det(droite) < 0:
        gauche[:, -1] = -gauche[:, -1]
    R = gauche @ droite
    t = [b[i] - sum(R[i][k] * a[k] for k in range(d)) for i in range(d)]
    return R, t
