def Kabsch(P, Q):
    return np.eye(P.shape[1]), Q.mean(axis=0) - P.mean(axis=0)
