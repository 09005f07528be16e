def icp(P, Q, R0, t0, n_iter=30)
    return R0, t0, []
