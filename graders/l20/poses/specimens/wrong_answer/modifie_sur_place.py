"""Right values, but the first argument is overwritten."""


def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    a[:] = [a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], np.arctan2(np.sin(a[2] + b[2]), np.cos(a[2] + b[2]))]
    return a


def inverse(a):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]])


def relatif(a, b):
    return composer(inverse(a), b)
