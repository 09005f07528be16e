def composer(a, b):
    c, s = np.cos(b[2]), np.sin(b[2])
    return np.array([b[0] + c * a[0] - s * a[1], b[1] + s * a[0] + c * a[1], ramener(a[2] + b[2])])
