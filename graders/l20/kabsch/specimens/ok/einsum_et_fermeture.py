def centrer(X):
    milieu = np.einsum("ik->k", X) / X.shape[0]
    return milieu, X - milieu


def kabsch(P, Q):
    (mp, p), (mq, q) = centrer(P), centrer(Q)
    u, s, v = np.linalg.svd(np.einsum("ni,nj->ij", p, q) / len(p), full_matrices=True)

    def assemble(dernier):
        return np.einsum("ki,k,jk->ij", v, [*[1.0] * (len(s) - 1), dernier], u)

    R = assemble(1.0) if np.linalg.det(assemble(1.0)) > 0 else assemble(-1.0)
    return R, mq - np.einsum("ij,j->i", R, mp)
