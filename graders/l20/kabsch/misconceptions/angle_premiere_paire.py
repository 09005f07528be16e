def kabsch(P, Q):
    p, q = P.mean(axis=0), Q.mean(axis=0)
    a, b = (P - p)[0], (Q - q)[0]
    angle = np.arctan2(b[1], b[0]) - np.arctan2(a[1], a[0])
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return R, q - R @ p
