def corriger2d(bel, scan_obs, sigma=0.5):
    carres = np.sum((scan_obs - ATTENDUS) ** 2, axis=1)
    nouvelle = np.zeros((H, W))
    nouvelle[Y, X] = bel[Y, X] * np.exp(-carres / (2 * 0.5**2))
    return nouvelle / nouvelle.sum()
