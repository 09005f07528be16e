def composer(a, b):
    return np.array([a[0] + b[0], a[1] + b[1], ramener(a[2] + b[2])])
