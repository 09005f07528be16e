I = lambda n: np.diag([1.0] * n)
gain = lambda P, H, R: np.linalg.solve((H @ P @ H.T + R).T, (P @ H.T).T).T
predire = lambda x, P, F, Q: (F @ x, Q + F @ P @ F.T)
applique = lambda x, P, z, H, K: [x - K @ (H @ x - z), (I(len(x)) - K @ H) @ P]
corriger = lambda x, P, z, H, R: applique(x, P, z, H, gain(P, H, R))
