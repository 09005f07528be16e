TOUTES = np.array([[x + 0.5, y + 0.5, 0.0] for y in range(H) for x in range(W)])
TOUS_ATTENDUS = lidar_lot(TOUTES, 4)


def corriger2d(bel, scan_obs, sigma=0.5):
    carres = np.sum((scan_obs - TOUS_ATTENDUS) ** 2, axis=1).reshape(H, W)
    nouvelle = np.exp(-carres / (2 * sigma**2))
    return nouvelle / nouvelle.sum()
