def correction(e, J, W):
    H = J.T @ W @ J
    b = J.T @ e
    delta = np.zeros(len(b))
    delta[3:] = np.linalg.solve(H[3:, 3:], -b[3:])
    return delta.reshape(-1, 3)
