def predire(x, P, F, Q):
    return np.einsum("ij,j->i", F, x), np.einsum("ij,jk,lk->il", F, P, F) + Q


def corriger(x, P, z, H, R):
    S = np.einsum("ai,ij,bj->ab", H, P, H) + R
    K = np.einsum("ij,aj,ab->ib", P, H, np.linalg.inv(S))
    reste = np.identity(x.size) - np.einsum("ia,aj->ij", K, H)
    return x + np.einsum("ia,a->i", K, z - np.einsum("ai,i->a", H, x)), np.einsum("ij,jk->ik", reste, P)
