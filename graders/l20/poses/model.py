def ramener(angle):
    return np.pi - (np.pi - angle) % (2 * np.pi)


def composer(a, b):
    x1, y1, t1 = a
    x2, y2, t2 = b
    c, s = np.cos(t1), np.sin(t1)
    dx = c * x2 - s * y2
    dy = s * x2 + c * y2
    return np.array([x1 + dx, y1 + dy, ramener(t1 + t2)])


def inverse(a):
    x, y, t = a
    c, s = np.cos(-t), np.sin(-t)
    u = -(c * x - s * y)
    v = -(s * x + c * y)
    return np.array([u, v, ramener(-t)])


def relatif(a, b):
    xa, ya, ta = a
    xb, yb, tb = b
    c, s = np.cos(-ta), np.sin(-ta)
    ex, ey = xb - xa, yb - ya
    u = c * ex - s * ey
    v = s * ex + c * ey
    return np.array([u, v, ramener(tb - ta)])
