"""The rotation by the adjugate's sum, without any decomposition; composer and inverse of the poses exercise."""


def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    t = a[2] + b[2]
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], np.arctan2(np.sin(t), np.cos(t))])


def inverse(a):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]])


def ate(estimees, verite):
    E, V = estimees.copy()[:, 0:2], verite.copy()[:, 0:2]
    E -= E.mean(axis=0)
    V -= V.mean(axis=0)
    H = V.T @ E
    M = H + np.array([[H[1, 1], -H[1, 0]], [-H[0, 1], H[0, 0]]])
    R = M / np.sqrt(np.linalg.det(M))
    reste = V - E @ R.T
    return np.sqrt(np.trace(reste @ reste.T) / len(V))


def rpe(estimees, verite, delta):
    normes = []
    i = 0
    while i + delta < len(verite):
        d = composer(inverse(estimees[i]), estimees[i + delta])
        v = composer(inverse(verite[i]), verite[i + delta])
        e = composer(inverse(d), v)
        normes.append(np.hypot(e[0], e[1]))
        i += 1
    return np.sqrt(np.mean(np.square(normes)))
