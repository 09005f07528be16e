corde = lambda Q: np.r_[Q[1:], Q[-1:]] - np.r_[Q[:1], Q[:-1]]
unitaire = lambda T: T / np.linalg.norm(T, axis=1)[:, None]
normales = lambda Q: unitaire(corde(Q)[:, ::-1] * [1, -1])
derivees = lambda P, N: np.c_[N, N[:, 1] * (P - P.mean(0))[:, 0] - N[:, 0] * (P - P.mean(0))[:, 1]]
moyennes = lambda J, r: (J.T @ J / len(J), J.T @ r / len(J))
systeme_droite = lambda P, Q, N: moyennes(derivees(P, N), (N * (P - Q)).sum(1))
coupe = lambda f, V, garde: V[:, garde(f)]
directions_libres = lambda A, seuil=0.01: coupe(*np.linalg.eigh(A), lambda f: f < seuil).T
pas_droite = lambda A, g, seuil=0.01: -sum(
    (v * (v @ g) / f for f, v in zip(np.linalg.eigh(A)[0], np.linalg.eigh(A)[1].T) if f >= seuil), start=np.zeros(3)
)
