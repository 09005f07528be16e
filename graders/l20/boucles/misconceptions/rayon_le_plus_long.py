def signature(scan):
    return np.array([np.max(scan)])
