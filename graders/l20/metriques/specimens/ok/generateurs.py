"""Generators and itertools; pow for the root; much is printed."""
import itertools


def rms(carres):
    carres = list(carres)
    print("carrés :", carres)
    return pow(sum(carres) / len(carres), 0.5)


def positions(trajectoire):
    xy = np.delete(trajectoire, 2, axis=1)
    return xy - np.average(xy, axis=0)


def ate(e, v):
    a, b = positions(e), positions(v)
    c = sum(np.dot(p, q) for p, q in zip(a, b))
    s = sum(np.cross(np.append(p, 0), np.append(q, 0))[2] for p, q in zip(a, b))
    h = np.hypot(c, s)
    M = np.array([[c, -s], [s, c]]) / h
    return rms(np.sum((M @ p - q) ** 2) for p, q in zip(a, b))


def vues(trajectoire, pas):
    for a, b in zip(trajectoire, itertools.islice(trajectoire, pas, None)):
        avant = np.array([np.cos(a[2]), np.sin(a[2])])
        gauche = np.array([-avant[1], avant[0]])
        yield (b - a)[:2] @ avant, (b - a)[:2] @ gauche


def rpe(e, v, pas):
    return rms((x - z) ** 2 + (y - w) ** 2 for (x, y), (z, w) in zip(vues(e, pas), vues(v, pas)))
