"""A structured array, and in-place writing in copies."""
TYPE = np.dtype([("x", float), ("y", float), ("theta", float)])


def lire(pas):
    return np.ascontiguousarray(pas, dtype=float).view(TYPE)[:, 0]


def avance(pas):
    p = lire(pas)
    return p["x"] * np.cos(p["theta"] / 2) + p["y"] * np.sin(p["theta"] / 2)


def etalonner(pas, vrais):
    p, v, d = lire(pas), lire(vrais), avance(pas)
    gram = np.array([[p["theta"] @ p["theta"], p["theta"] @ d], [d @ p["theta"], d @ d]])
    droite = np.array([p["theta"] @ v["theta"], d @ v["theta"]])
    return np.append(d @ avance(vrais) / gram[1, 1], np.linalg.inv(gram) @ droite)


def corriger(pas, gamma, beta, alpha):
    q = lire(pas).copy()
    q["theta"] *= beta
    q["theta"] += alpha * avance(pas)
    a = (q["theta"] - pas[:, 2]) / 2
    q["x"] = gamma * (np.cos(a) * pas[:, 0] - np.sin(a) * pas[:, 1])
    q["y"] = gamma * (np.sin(a) * pas[:, 0] + np.cos(a) * pas[:, 1])
    return np.column_stack([q["x"], q["y"], q["theta"]])
