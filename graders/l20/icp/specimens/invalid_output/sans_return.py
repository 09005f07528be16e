def icp(P, Q, R0, t0, n_iter=30):
    R, t = R0, t0
    for _ in range(n_iter):
        A = P @ R.T + t
        B = Q[np.argmin(np.sum((A[:, None] - Q) ** 2, axis=2), axis=1)]
    print(R, t)
