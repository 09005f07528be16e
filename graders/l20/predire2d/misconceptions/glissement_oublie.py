def arrivees(du, dv):
    return [(1.0, du, dv)]
