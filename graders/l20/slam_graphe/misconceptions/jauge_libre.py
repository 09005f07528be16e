def correction(e, J, W):
    return np.linalg.solve(J.T @ W @ J, -J.T @ W @ e).reshape(-1, 3)
