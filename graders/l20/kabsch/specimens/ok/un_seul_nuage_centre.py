"""Only P is centred (the sum is the same), points as columns, H divided by n and transposed, V turned at the end."""
import scipy.linalg


def kabsch(P, Q):
    p = np.average(P, axis=0)[:, None]
    q = np.average(Q, axis=0)[:, None]
    K = Q.T @ (P.T - p).T / len(P)
    U, s, Wt = scipy.linalg.svd(K)
    if np.linalg.det(U) * np.linalg.det(Wt) < 0:
        U[:, -1] = -U[:, -1]
    R = U @ Wt
    t = (q - R @ p).ravel()
    return R.tolist(), t.tolist()
