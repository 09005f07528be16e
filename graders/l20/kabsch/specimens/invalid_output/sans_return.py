def kabsch(P, Q):
    H = (P - P.mean(axis=0)).T @ (Q - Q.mean(axis=0))
    U, S, Vt = np.linalg.svd(H)
    print(Vt.T @ U.T)
