"""Numbers that overflow when squared."""


def kabsch(P, Q):
    d = P.shape[1]
    return 1e200 * np.eye(d), [10**400] * d
