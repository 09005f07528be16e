"""The textbook's mend: the last row of Vt changes sign when the determinant is negative; a tuple of lists."""


def kabsch(P, Q):
    centre_p, centre_q = P.sum(0) / len(P), Q.sum(0) / len(Q)
    U, S, Vt = np.linalg.svd(np.dot((P - centre_p).T, Q - centre_q))
    R = Vt.T.dot(U.T)
    if np.linalg.det(R) < 0:
        Vt[-1, :] *= -1
        R = Vt.T.dot(U.T)
    return R.tolist(), (centre_q - R.dot(centre_p)).tolist()
