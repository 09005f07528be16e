def ramener(angle):
    """Ramène un angle, ou un tableau d'angles, dans l'intervalle ]−π, π]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


def vue(pose, point):
    """Un point (x, y) du monde, dans le repère du robot placé en pose ; et sa dérivée par rapport au cap."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    tourne = np.array([[c, s], [-s, c]])  # R(θ)ᵀ : du monde vers le robot
    derivee = np.array([[-s, c], [-c, -s]])  # sa dérivée par rapport à θ
    ecart = point - pose[:2]
    return tourne @ ecart, tourne, derivee @ ecart


def arete_pose(xi, xj, z):
    """L'erreur (3,) d'une arête pose–pose, et ses dérivées par rapport à xi et à xj (3 × 3)."""
    position, tourne, par_theta = vue(xi, xj[:2])
    e = np.array([*(position - z[:2]), ramener(xj[2] - xi[2] - z[2])])
    A, B = np.zeros((3, 3)), np.zeros((3, 3))
    A[:2, :2], A[:2, 2], A[2, 2] = -tourne, par_theta, -1.0
    B[:2, :2], B[2, 2] = tourne, 1.0
    return e, A, B


def arete_amer(pose, amer, z):
    """L'erreur (2,) d'une observation, et ses dérivées par rapport à la pose (2 × 3) et à l'amer (2 × 2)."""
    position, tourne, par_theta = vue(pose, amer)
    return position - z, np.column_stack([-tourne, par_theta]), tourne


def systeme(poses, amers, aretes, observations):
    """H = JᵀΩJ et b = JᵀΩe de toutes les mesures ; aucune pose n'est fixée."""
    n, m = len(poses), len(amers)
    H, b = np.zeros((3 * n + 2 * m, 3 * n + 2 * m)), np.zeros(3 * n + 2 * m)

    def ajouter(premier, second, e, A, B, omega):
        # Une mesure ne touche que deux nœuds : quatre blocs de H, deux morceaux de b. Tout s'additionne.
        for lignes, gauche in ((premier, A), (second, B)):
            b[lignes] += gauche.T @ omega @ e
            for colonnes, droite in ((premier, A), (second, B)):
                H[lignes, colonnes] += gauche.T @ omega @ droite

    def pose(i):
        return slice(3 * i, 3 * i + 3)

    def amer(j):
        return slice(3 * n + 2 * j, 3 * n + 2 * j + 2)

    for i, j, z, omega in aretes:
        ajouter(pose(i), pose(j), *arete_pose(poses[i], poses[j], z), omega)
    for i, j, z, omega in observations:
        ajouter(pose(i), amer(j), *arete_amer(poses[i], amers[j], z), omega)
    return H, b


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    x, a = np.array(poses), np.array(amers)
    for _ in range(2):  # deux tours suffiront bien
        H, b = systeme(x, a, aretes, observations)
        pas = np.concatenate([np.zeros(3), np.linalg.solve(H[3:, 3:], -b[3:])])
        x += pas[: x.size].reshape(-1, 3)
        a += pas[x.size :].reshape(-1, 2)
        x[:, 2] = ramener(x[:, 2])
    return x, a
