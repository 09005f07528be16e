"""The joint law of state and reading, conditioned on the reading."""


def predire(x, P, F, Q):
    n = len(x)
    M = np.hstack([F, np.eye(n)])
    C = np.block([[P, np.zeros((n, n))], [np.zeros((n, n)), Q]])
    return M @ np.concatenate([x, np.zeros(n)]), M @ C @ M.T


def corriger(x, P, z, H, R):
    n = len(x)
    G = np.vstack([np.eye(n), H])
    moyenne, C = G @ x, G @ P @ G.T
    C[n:, n:] += R
    pente = C[:n, n:] @ np.linalg.inv(C[n:, n:])
    return moyenne[:n] + pente @ (z - moyenne[n:]), C[:n, :n] - pente @ C[n:, :n]
