from collections import namedtuple

Pose = namedtuple("Pose", "x y t")
Paire = namedtuple("Paire", "A B")


def residu(xi, xj, z):
    i, j, m = Pose(*xi), Pose(*xj), Pose(*z)
    dx, dy = j.x - i.x, j.y - i.y
    parts = {
        "x": np.cos(i.t) * dx + np.sin(i.t) * dy - m.x,
        "y": np.cos(i.t) * dy - np.sin(i.t) * dx - m.y,
        "t": np.arctan2(np.sin(j.t - i.t - m.t), np.cos(j.t - i.t - m.t)),
    }
    return tuple(parts.values())


def jacobiennes(xi, xj, z):
    i, j = Pose(*xi), Pose(*xj)
    c, s = np.cos(i.t), np.sin(i.t)
    derivees = {
        ("x", "xi"): -c, ("x", "yi"): -s, ("x", "ti"): -s * (j.x - i.x) + c * (j.y - i.y),
        ("y", "xi"): s, ("y", "yi"): -c, ("y", "ti"): -c * (j.x - i.x) - s * (j.y - i.y),
        ("t", "ti"): -1.0,
        ("x", "xj"): c, ("x", "yj"): s, ("y", "xj"): -s, ("y", "yj"): c, ("t", "tj"): 1.0,
    }
    A, B = ([[derivees.get((l, q + p), 0.0) for q in "xyt"] for l in "xyt"] for p in "ij")
    return Paire(A, B)


def contribution(xi, xj, z, omega):
    p = jacobiennes(xi, xj, z)
    J = np.array([a + b for a, b in zip(p.A, p.B)])
    e = np.array(residu(xi, xj, z))
    return {0: J.T @ omega @ J}[0], J.T @ (omega @ e)
