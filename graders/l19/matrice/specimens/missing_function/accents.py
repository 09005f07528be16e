def prédire(x, P, F, Q):
    return F @ x, F @ P @ F.T + Q


def mettre_a_jour(x, P, z, H, R):
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ (z - H @ x), (np.eye(len(x)) - K @ H) @ P
