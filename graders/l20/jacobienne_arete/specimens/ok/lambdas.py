rot = lambda t: np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
tour = lambda a: -((np.pi - a) % (2 * np.pi) - np.pi)
residu = lambda xi, xj, z: np.r_[(xj[:2] - xi[:2]) @ rot(xi[2]) - z[:2], tour(xj[2] - xi[2] - z[2])]
bord = lambda M, haut, coin: np.r_[np.c_[M, haut], [[0, 0, coin]]]
jacobiennes = lambda xi, xj, z: (
    bord(-rot(xi[2]).T, rot(xi[2] + np.pi / 2).T @ (xj[:2] - xi[:2]), -1),
    bord(rot(xi[2]).T, np.zeros(2), 1),
)
produit = lambda J, W, e: (J.T @ W @ J, J.T @ W @ e)
contribution = lambda xi, xj, z, omega: produit(np.hstack(jacobiennes(xi, xj, z)), omega, residu(xi, xj, z))
