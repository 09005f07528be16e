def predire2d(bel, du, dv):
    nouvelle = sum(p * np.roll(bel, (dy, dx), axis=(0, 1)) for p, dx, dy in arrivees(du, dv))
    nouvelle[~libres] = 0
    total = nouvelle.sum()
    return nouvelle / total if total > 0 else nouvelle
