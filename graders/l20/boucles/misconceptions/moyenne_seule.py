def signature(scan):
    return np.array([np.mean(scan)])
