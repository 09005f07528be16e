def inverse(a):
    return np.array([-a[0], -a[1], ramener(-a[2])])
