def ramener(angle):
    """Ramène un angle (en radians) dans l'intervalle ]−π, π]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


def odometrie(pose, ds_g, ds_d, L):
    """La pose après un pas, par la formule du point milieu."""
    x, y, theta = pose
    # Le milieu de l'essieu avance de la moyenne des deux roues...
    ds = (ds_g + ds_d) / 2
    # ... et la roue qui va le plus loin fait tourner le robot de l'autre côté.
    dtheta = (ds_d - ds_g) / L
    # Pendant le pas, le cap passe de theta à theta + dtheta : on avance selon celui du milieu.
    milieu = theta + dtheta / 2
    return np.array([x + ds * np.cos(milieu), y + ds * np.sin(milieu), ramener(theta + dtheta)])


def sigma_dtheta(sigma_g, sigma_d, L):
    """L'écart-type de la rotation d'un pas, par propagation linéaire."""
    # Δθ est une combinaison linéaire des deux chemins : leurs variances s'ajoutent, même pour une différence.
    return np.sqrt(sigma_g**2 + sigma_d**2) / L
