def kabsch(P, Q):
    """La rotation R et la translation t qui amènent les points P au plus près des points Q."""
    # On ramène chaque nuage autour de son centre : il ne reste alors qu'une rotation à trouver.
    p_moyen = np.mean(P, axis=0)
    q_moyen = np.mean(Q, axis=0)
    # Une ligne par point : ce produit est bien la somme des (p − p_moyen)(q − q_moyen)ᵀ, une matrice d × d.
    H = (P - p_moyen).T @ (Q - q_moyen)
    # Attention : numpy renvoie la transposée de V.
    U, _, Vt = np.linalg.svd(H)
    V = Vt.T
    # V Uᵀ peut être une symétrie. On retourne alors la direction qui coûte le moins : celle de la plus petite
    # valeur singulière, qui est la dernière.
    D = np.eye(len(H))
    D[-1, -1] = np.sign(np.linalg.det(V @ U.T))
    R = V @ D @ U.T
    # Le centre de P, une fois tourné puis déplacé, doit tomber sur celui de Q.
    t = q_moyen - R @ p_moyen
    return R, t
