def predire(x, P, F, Q):
    """La croyance après un pas du modèle x' = F x + bruit de covariance Q."""
    # Une covariance se transporte des deux côtés : c'est une moyenne de produits (erreur)(erreur)ᵀ.
    return F @ x, F @ P @ F.T + Q


def corriger(x, P, z, H, R):
    """La croyance après la mesure z = H x + bruit de covariance R."""
    # Ce que la mesure apporte de neuf, et la covariance de cet écart.
    innovation = z - H @ x
    S = H @ P @ H.T + R
    # Le gain : ce que l'état a en commun avec la mesure, divisé par le doute de la mesure.
    K = P @ H.T @ np.linalg.inv(S)
    return x + K @ innovation, (np.eye(len(x)) - K @ H) @ P
