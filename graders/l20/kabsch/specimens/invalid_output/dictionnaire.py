def kabsch(P, Q):
    return {"R": np.eye(P.shape[1]), "t": np.zeros(P.shape[1])}
