def inverse(a):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([c * a[0] + s * a[1], -s * a[0] + c * a[1], ramener(-a[2])])
