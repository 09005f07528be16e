def relatif(a, b):
    return np.array([b[0] - a[0], b[1] - a[1], ramener(b[2] - a[2])])
