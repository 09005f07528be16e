"""A product of two 3 × 3 matrices, and the inverse written by blocks; float128 where there is one."""
T = np.longdouble


def en_matrice(p):
    x, y, t = (T(v) for v in p)
    return np.array([[np.cos(t), -np.sin(t), x], [np.sin(t), np.cos(t), y], [0, 0, 1]], dtype=T)


def en_pose(M):
    return np.array([M[0, 2], M[1, 2], np.arctan2(M[1, 0], M[0, 0])]).astype(float)


def inversee(M):
    N = np.eye(3, dtype=T)
    N[:2, :2] = M[:2, :2].T
    N[:2, 2] = -M[:2, :2].T @ M[:2, 2]
    return N


def composer(a, b):
    return en_pose(en_matrice(a) @ en_matrice(b))


def inverse(a):
    return en_pose(inversee(en_matrice(a)))


def relatif(a, b):
    return en_pose(inversee(en_matrice(a)) @ en_matrice(b))
