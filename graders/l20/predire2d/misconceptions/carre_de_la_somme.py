def corriger2d(bel, scan_obs, sigma=0.5):
    ecarts = np.sum(scan_obs - ATTENDUS, axis=1)
    nouvelle = np.zeros((H, W))
    nouvelle[Y, X] = bel[Y, X] * np.exp(-(ecarts**2) / (2 * sigma**2))
    return nouvelle / nouvelle.sum()
