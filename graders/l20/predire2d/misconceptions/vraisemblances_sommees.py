def corriger2d(bel, scan_obs, sigma=0.5):
    rayons = np.exp(-((scan_obs - ATTENDUS) ** 2) / (2 * sigma**2))
    nouvelle = np.zeros((H, W))
    nouvelle[Y, X] = bel[Y, X] * rayons.sum(axis=1)
    return nouvelle / nouvelle.sum()
