def arrivees(du, dv):
    if (du, dv) == (0, 0):
        return [(1.0, 0, 0)]
    return [(0.8, -du, -dv), (0.1, -du + dv, -dv + du), (0.1, -du - dv, -dv - du)]
