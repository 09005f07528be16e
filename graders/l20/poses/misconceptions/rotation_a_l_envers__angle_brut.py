def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([a[0] + c * b[0] + s * b[1], a[1] - s * b[0] + c * b[1], a[2] + b[2]])
