def signature(scan):
    return np.mean(scan)
