def lancer_rayon(libres, x, y, angle, portee_max):
    f = np.float32
    h, w = libres.shape
    dx, dy = f(np.cos(angle)), f(np.sin(angle))
    t = f(0)
    while t < f(portee_max):
        px, py = f(x) + t * dx, f(y) + t * dy
        if px < 0 or py < 0 or px >= w or py >= h or not libres[int(py), int(px)]:
            return np.float32(max(t - f(0.02), f(0)))
        t = t + f(0.04)
    return f(portee_max)
