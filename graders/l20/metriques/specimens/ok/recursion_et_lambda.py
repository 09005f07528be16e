"""A recursive sum over the pairs, lambdas, polar coordinates."""
ate = lambda e, v: (lambda A, B: (lambda H: np.sqrt(max(0.0, np.mean(
    np.sum((A @ np.array([[np.cos(H), np.sin(H)], [-np.sin(H), np.cos(H)]]) - B) ** 2, axis=1)
))))(np.arctan2(np.sum(A[:, 0] * B[:, 1] - A[:, 1] * B[:, 0]), np.sum(A * B))))(
    e[:, :2] - e[:, :2].mean(0), v[:, :2] - v[:, :2].mean(0)
)


def polaire(a, b):
    return np.hypot(b[0] - a[0], b[1] - a[1]), np.arctan2(b[1] - a[1], b[0] - a[0]) - a[2]


def total(e, v, delta, i=0):
    if i + delta >= len(e):
        return 0.0
    (r, u), (s, w) = polaire(e[i], e[i + delta]), polaire(v[i], v[i + delta])
    dx, dy = r * np.cos(u) - s * np.cos(w), r * np.sin(u) - s * np.sin(w)
    return dx**2 + dy**2 + total(e, v, delta, i + 1)


def rpe(e, v, delta):
    return np.sqrt(total(e, v, delta) / (len(e) - delta))
