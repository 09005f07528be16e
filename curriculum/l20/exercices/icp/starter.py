def icp(P, Q, R0, t0, n_iter=30):
    """Le mouvement (R, t) qui amène P sur Q, trouvé par ICP, et
    la suite des erreurs.
    """
    R, t = R0, t0
    erreurs = []
    # À vous de jouer.
    return R, t, erreurs
