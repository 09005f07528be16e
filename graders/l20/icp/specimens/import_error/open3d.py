import open3d


def icp(P, Q, R0, t0, n_iter=30):
    return open3d.icp(P, Q)
