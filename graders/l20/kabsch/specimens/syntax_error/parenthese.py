def kabsch(P, Q):
    H = (P - P.mean(axis=0).T @ (Q - Q.mean(axis=0))
    return H, 0
