def arrivees(du, dv):
    cote = (0, 1) if du != 0 else (1, 0)
    return [(0.8, du, dv), (0.1, du + cote[0], dv + cote[1]), (0.1, du - cote[0], dv - cote[1])]
