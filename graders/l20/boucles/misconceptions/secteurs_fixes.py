def signature(scan):
    return scan.reshape(6, 6).mean(axis=1)
