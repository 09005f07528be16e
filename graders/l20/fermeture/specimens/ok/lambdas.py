from scipy.stats import chi2

indices = lambda i, j: np.r_[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
bordee = lambda M: np.block([[np.zeros((3, 3)), np.zeros((3, len(M)))], [np.zeros((len(M), 3)), M]])
covariance_jointe = lambda H, i, j: bordee(np.linalg.inv(H[3:, 3:]))[np.ix_(indices(i, j), indices(i, j))]
rot = lambda t: np.array([[np.cos(t), np.sin(t), 0], [-np.sin(t), np.cos(t), 0], [0, 0, 1]])
colonne = lambda w: np.array([[0, 0, w[1]], [0, 0, -w[0]], [0, 0, 0]])
J = lambda xi, xj: np.hstack([-rot(xi[2]) + colonne(rot(xi[2]) @ (xj - xi)), rot(xi[2])])
covariance_relative = lambda xi, xj, sigma: J(xi, xj) @ sigma @ J(xi, xj).T
tour = lambda e: np.array([e[0], e[1], np.arctan2(np.sin(e[2]), np.cos(e[2]))])
carre = lambda e, S: e @ np.linalg.inv(S) @ e
avis = lambda d2, niveau: (d2, bool(chi2.cdf(d2, 3) <= niveau))
juger_fermeture = lambda xi, xj, z, sigma, omega, niveau=0.95: avis(
    carre(tour(rot(xi[2]) @ (xj - xi) - z), covariance_relative(xi, xj, sigma) + np.linalg.inv(omega)), niveau
)
