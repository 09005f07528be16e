def kabsch(P, Q):
    p, q = P.mean(axis=0), Q.mean(axis=0)
    a, b = P - p, Q - q
    angle = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a[:, :2] * b[:, :2]))
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return R, q - R @ p
