"""Lambdas where a def would do, the normal equations by least squares on whitened rows."""
tour = lambda t: (t + np.pi) % (2 * np.pi) - np.pi
R = lambda t: np.array([[np.cos(t), np.sin(t), 0], [-np.sin(t), np.cos(t), 0], [0, 0, 1]])
ramene = lambda e: np.append(e[:2], tour(e[2]))
erreur = lambda xi, xj, z: ramene(R(xi[2]) @ (xj - xi) - z)
dtheta = lambda xi, xj: np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 0]]) @ R(xi[2]) @ (xj - xi)
A = lambda xi, xj: -R(xi[2]) + np.outer(dtheta(xi, xj), [0, 0, 1])
place = lambda n, k, B: np.kron(np.eye(n)[k], B)
ligne = lambda x, i, j: place(len(x), i, A(x[i], x[j])) + place(len(x), j, R(x[i][2]))
blanc = lambda omega: np.linalg.cholesky(omega).T
tout = lambda x, aretes: np.vstack([blanc(o) @ ligne(x, i, j) for i, j, z, o in aretes])
reste = lambda x, aretes: np.hstack([blanc(o) @ erreur(x[i], x[j], z) for i, j, z, o in aretes])
pas = lambda x, aretes: np.linalg.lstsq(tout(x, aretes)[:, 3:], -reste(x, aretes), rcond=None)[0].reshape(-1, 3)
corrige = lambda x, d: np.array([x[0], *map(ramene, x[1:] + d)])
gauss_newton = lambda poses, aretes, n=10: poses if n == 0 else gauss_newton(corrige(poses, pas(poses, aretes)), aretes, n - 1)
