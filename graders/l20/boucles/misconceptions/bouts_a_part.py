def signature(scan):
    return np.concatenate([np.sort(scan), np.sort(np.abs(np.diff(scan)))])
