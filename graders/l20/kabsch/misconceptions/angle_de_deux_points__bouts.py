def kabsch(P, Q):
    a, b = P[-1] - P[0], Q[-1] - Q[0]
    angle = np.arctan2(b[1], b[0]) - np.arctan2(a[1], a[0])
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return R, Q.mean(axis=0) - R @ P.mean(axis=0)
