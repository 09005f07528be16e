def lancer_rayon(libres, x, y, angle, portee_max):
    H, W = libres.shape
    d = np.array([np.cos(angle), np.sin(angle)])
    case = np.floor([x, y]).astype(int)
    pas = np.where(d > 0, 1, -1)
    with np.errstate(divide="ignore"):
        delta = np.abs(1 / d)
        tmax = np.where(d == 0, np.inf, (case + (d > 0) - (x, y)) / d)
    while True:
        axe = np.argmin(tmax)
        t = tmax[axe]
        if t > portee_max:
            return np.array(portee_max)
        case[axe] += pas[axe]
        tmax[axe] += delta[axe]
        if not (0 <= case[0] < W and 0 <= case[1] < H) or not libres[case[1], case[0]]:
            return np.array(t)
