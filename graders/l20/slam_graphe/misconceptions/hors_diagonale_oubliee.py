def correction(e, J, W):
    H = J.T @ W @ J
    b = J.T @ W @ e
    delta = np.zeros(len(b))
    for p in range(3, len(b), 3):
        delta[p : p + 3] = np.linalg.solve(H[p : p + 3, p : p + 3], -b[p : p + 3])
    return delta.reshape(-1, 3)
