def signature(scan):
    return np.array([scan[0]])
