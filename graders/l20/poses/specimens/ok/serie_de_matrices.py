"""The matrix exponential of a rotation rate, by its series; einsum."""
J = np.array([[0.0, -1.0], [1.0, 0.0]])


def expm(M):
    terme, somme = np.eye(2), np.eye(2)
    for k in range(1, 40):
        terme = terme @ M / k
        somme = somme + terme
    return somme


def ramener(t):
    t = np.fmod(t, 2 * np.pi)
    if t > np.pi:
        t -= 2 * np.pi
    elif t < -np.pi:
        t += 2 * np.pi
    return t


def composer(a, b):
    tourne = np.einsum("ij,j->i", expm(a[2] * J), b[:2])
    return np.concatenate((a[:2] + tourne, [ramener(a[2] + b[2])]))


def inverse(a):
    tourne = np.einsum("ji,j->i", expm(a[2] * J), a[:2])
    return np.concatenate((-tourne, [ramener(-a[2])]))


def relatif(a, b):
    return composer(inverse(a), b)
