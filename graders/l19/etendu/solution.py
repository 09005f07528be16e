def distance_et_jacobien(x, balise):
    """La distance du robot à la balise, et sa dérivée par rapport à la position du robot."""
    ecart = x - balise
    d = np.sqrt(ecart @ ecart)
    # S'éloigner d'un mètre de la balise, droit devant elle, augmente la distance d'un mètre :
    # la dérivée est le vecteur de longueur 1 qui va de la balise au robot.
    return d, ecart / d


def corriger_distance(x, P, z, balise, r):
    """La croyance après la mesure z de la distance à la balise, de variance r."""
    d, derivee = distance_et_jacobien(x, balise)
    # La même correction que le filtre linéaire, la dérivée faisant la seule ligne de H...
    H = np.atleast_2d(derivee)
    S = H @ P @ H.T + r
    K = P @ H.T / S
    # ... mais l'innovation compare la mesure à la vraie distance, et non à H x.
    return x + K.ravel() * (z - d), (np.eye(2) - K @ H) @ P
