avance = lambda p: p[:, 0] * np.cos(p[:, 2] / 2) + p[:, 1] * np.sin(p[:, 2] / 2)
ajuste = lambda A, y: np.linalg.lstsq(A, y, rcond=None)[0]
etalonner = lambda p, v: (
    *ajuste(avance(p)[:, None], avance(v)),
    *ajuste(np.column_stack([p[:, 2], avance(p)]), v[:, 2]),
)
tourne = lambda p, a: np.column_stack(
    [np.cos(a) * p[:, 0] - np.sin(a) * p[:, 1], np.sin(a) * p[:, 0] + np.cos(a) * p[:, 1]]
)
corriger = lambda p, g, b, a: np.column_stack(
    [g * tourne(p, ((b - 1) * p[:, 2] + a * avance(p)) / 2), b * p[:, 2] + a * avance(p)]
)
