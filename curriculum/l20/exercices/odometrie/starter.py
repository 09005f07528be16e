def odometrie(pose, ds_g, ds_d, L):
    """La pose après un pas : formule du point milieu."""
    x, y, theta = pose
    # À vous de jouer.
    return np.array([0.0, 0.0, 0.0])


def sigma_dtheta(sigma_g, sigma_d, L):
    """L'écart-type de la rotation d'un pas, en radians."""
    return 0.0
