def meilleur_mouvement(P, Q):
    """La rotation et la translation qui amènent les points P au plus près de leurs partenaires Q."""
    p_moyen, q_moyen = P.mean(axis=0), Q.mean(axis=0)
    # La somme des (p − p_moyen) qᵀ : qu'un des deux nuages soit centré suffit.
    H = (P - p_moyen).T @ Q
    # Dans le plan, la rotation de Kabsch se lit sur H, sans SVD. C'est toujours une rotation, jamais une symétrie.
    angle = np.arctan2(H[0, 1] - H[1, 0], H[0, 0] + H[1, 1])
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return R, q_moyen - R @ p_moyen


def icp(P, Q, R0, t0, n_iter=30):
    """Recaler P sur Q, sans savoir quel point va avec lequel, en partant de (R0, t0)."""
    R, t = R0, t0
    erreurs = []
    for _ in range(n_iter):
        # (a) Apparier : chaque point de P, là où il est maintenant, prend le point de Q le plus proche.
        A = P @ R.T + t
        carres = np.sum((A[:, None, :] - Q[None, :, :]) ** 2, axis=2)
        partenaires = Q[np.argmin(carres, axis=1)]
        # (b) Déplacer : le meilleur mouvement de P (du P d'origine : rien à composer) pour ces paires-là.
        R, t = meilleur_mouvement(P, partenaires)
        erreurs.append(np.sum((P @ R.T + t - partenaires) ** 2))
    return R, t, erreurs
