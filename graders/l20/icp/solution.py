def meilleur_mouvement(P, Q):
    """La rotation et la translation qui amènent les points P au plus près de leurs partenaires Q (Kabsch)."""
    p_moyen, q_moyen = P.mean(axis=0), Q.mean(axis=0)
    U, _, Vt = np.linalg.svd((P - p_moyen).T @ (Q - q_moyen))
    # Un robot ne passe pas à travers le miroir : si V Uᵀ est une symétrie, on retourne la dernière direction.
    if np.linalg.det(Vt.T @ U.T) < 0:
        Vt[-1] = -Vt[-1]
    R = Vt.T @ U.T
    return R, q_moyen - R @ p_moyen


def icp(P, Q, R0, t0, n_iter=30):
    """Recaler P sur Q, sans savoir quel point va avec lequel, en partant de (R0, t0)."""
    R, t = R0, t0
    erreurs = []
    for _ in range(n_iter):
        # (a) Apparier : chaque point de P, là où il est maintenant, prend le point de Q le plus proche.
        ecarts = (P @ R.T + t)[:, None, :] - Q[None, :, :]
        carres = np.sum(ecarts**2, axis=2)
        paires = np.argmin(carres, axis=1)
        # (b) Déplacer : le meilleur mouvement de P (du P d'origine : rien à composer) pour ces paires-là.
        R, t = meilleur_mouvement(P, Q[paires])
        erreurs.append(np.sum((P @ R.T + t - Q[paires]) ** 2))
    return R, t, erreurs
