import cmath


def lancer_rayon(libres, x, y, angle, portee_max):
    depart, cap = complex(x, y), cmath.exp(1j * angle)
    for k in range(int(portee_max / 0.08) + 1):
        p = depart + 0.08 * k * cap
        if p.real < 0 or p.imag < 0 or p.real >= libres.shape[1] or p.imag >= libres.shape[0]:
            return min(0.08 * k, portee_max)
        if not libres[int(p.imag), int(p.real)]:
            return min(0.08 * k, portee_max)
    return portee_max
