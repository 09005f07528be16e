"""inverse and relatif solve for the pose that composed gives the other one."""


def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    x, y = np.array([[c, -s], [s, c]]).dot(b[:2]) + a[:2]
    return np.array([x, y, np.angle(np.exp(1j * (a[2] + b[2])))])


def relatif(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    x, y = np.linalg.solve([[c, -s], [s, c]], np.subtract(b, a)[:2])
    return np.array([x, y, np.angle(np.exp(1j * (b[2] - a[2])))])


def inverse(a):
    return relatif(a, np.zeros(3))
