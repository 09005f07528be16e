class Noeud:
    """Une pose ou un amer : où il est, et où sont ses inconnues."""

    def __init__(self, valeur, debut):
        self.valeur = np.array(valeur, dtype=float)
        self.place = slice(debut, debut + len(self.valeur))

    @property
    def T(self):
        x, y, t = self.valeur
        return np.array([[np.cos(t), -np.sin(t), x], [np.sin(t), np.cos(t), y], [0, 0, 1]])

    def bouger(self, pas):
        self.valeur = self.valeur + pas[self.place]
        if len(self.valeur) == 3:
            self.valeur[2] = np.arctan2(np.sin(self.valeur[2]), np.cos(self.valeur[2]))


class Arete:
    def __init__(self, a, b, z, omega):
        self.a, self.b, self.z, self.omega = a, b, z, omega

    def erreur(self):
        M = np.linalg.inv(self.a.T) @ self.b.T
        angle = np.arctan2(M[1, 0], M[0, 0]) - self.z[2]
        return np.array([M[0, 2] - self.z[0], M[1, 2] - self.z[1], np.arctan2(np.sin(angle), np.cos(angle))])

    def jacobiennes(self):
        R = self.a.T[:2, :2].T
        d = self.b.valeur[:2] - self.a.valeur[:2]
        A, B = -np.eye(3), np.eye(3)
        A[:2, :2], B[:2, :2] = -R, R
        A[:2, 2] = np.array([[0, 1], [-1, 0]]) @ R @ d
        return A, B


class Observation(Arete):
    def erreur(self):
        return (np.linalg.inv(self.a.T) @ [*self.b.valeur, 1])[:2] - self.z

    def jacobiennes(self):
        A, B = Arete.jacobiennes(self)
        return A[:2], B[:2, :2]


class Graphe:
    def __init__(self, poses, amers, aretes, observations):
        n = len(poses)
        self.poses = [Noeud(p, 3 * k) for k, p in enumerate(poses)]
        self.amers = [Noeud(a, 3 * n + 2 * k) for k, a in enumerate(amers)]
        self.mesures = [Arete(self.poses[i], self.poses[j], z, w) for i, j, z, w in aretes]
        self.mesures += [Observation(self.poses[i], self.amers[j], z, w) for i, j, z, w in observations]
        self.taille = 3 * n + 2 * len(amers)

    def systeme(self):
        H, b = np.zeros((self.taille, self.taille)), np.zeros(self.taille)
        for mesure in self.mesures:
            couples = list(zip((mesure.a.place, mesure.b.place), mesure.jacobiennes()))
            for p, J in couples:
                b[p] += J.T @ mesure.omega @ mesure.erreur()
                for q, K in couples:
                    H[p, q] += J.T @ mesure.omega @ K
        return H, b


def systeme(poses, amers, aretes, observations):
    return Graphe(poses, amers, aretes, observations).systeme()


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    graphe = Graphe(poses, amers, aretes, observations)
    for _ in range(n_iter):
        H, b = graphe.systeme()
        H[:3], b[:3] = 0, 0
        H[:3, :3] = np.eye(3)
        pas = np.linalg.solve(H, -b)
        for noeud in graphe.poses + graphe.amers:
            noeud.bouger(pas)
    return np.array([p.valeur for p in graphe.poses]), np.array([a.valeur for a in graphe.amers])
