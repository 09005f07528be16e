def systeme(poses, amers, aretes, observations):
    """H = JᵀΩJ et b = JᵀΩe, de taille 3n + 2m :
    les poses d'abord, puis les amers ; aucune pose n'est fixée.
    """
    n, m = len(poses), len(amers)
    H = np.zeros((3 * n + 2 * m, 3 * n + 2 * m))
    b = np.zeros(3 * n + 2 * m)
    for i, j, z, omega in aretes:
        # L'erreur, ses jacobiennes par rapport à x_i et à x_j...
        pass
    for i, j, z, omega in observations:
        # ... puis par rapport à x_i et à l_j.
        pass
    return H, b


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    """Les poses (n, 3) et les amers (m, 2) qui rendent Σ eᵀΩe
    minimale ; la première pose ne bouge pas.
    """
    x = np.array(poses, dtype=float)
    a = np.array(amers, dtype=float)
    for _ in range(n_iter):
        H, b = systeme(x, a, aretes, observations)
        # À vous de jouer : quel pas faut-il ajouter à x et à a ?
    return x, a
