def signature(scan):
    return np.array([np.histogram(scan, bins=10)[0].sum()])
