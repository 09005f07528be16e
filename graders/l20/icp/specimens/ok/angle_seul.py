"""The rotation is an angle that grows; errors of both halves would be too many, so the last alone is kept."""
def icp(P, Q, R0, t0, n_iter=30):
    theta, t = np.arctan2(R0[1, 0], R0[0, 0]), np.asarray(t0, dtype=float)

    def tourne(points, angle):
        c, s = np.cos(angle), np.sin(angle)
        return np.column_stack([c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]])

    erreur = None
    for _ in range(n_iter):
        A = tourne(P, theta) + t
        B = Q[np.argmin(np.hypot(A[:, :1] - Q[:, 0], A[:, 1:] - Q[:, 1]), axis=1)]
        a, b = A - A.mean(0), B - B.mean(0)
        pas = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
        theta += pas
        t = B.mean(0) - tourne(P.mean(0)[None], theta)[0]
        erreur = np.sum((tourne(P, theta) + t - B) ** 2)
    return np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]]), t, [erreur]
