"""Nothing but lambdas; the half turn may be written either way."""
tour = lambda t: (t + np.pi) % (2 * np.pi) - np.pi
R = lambda t: np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
composer = lambda a, b: np.append(a[:2] + R(a[2]) @ b[:2], tour(a[2] + b[2]))
inverse = lambda a: np.append(-R(a[2]).T @ a[:2], tour(-a[2]))
relatif = lambda a, b: np.append(R(a[2]).T @ (b[:2] - a[:2]), tour(b[2] - a[2]))
