"""The correction as weighted least squares of the prediction and of the reading."""


def predire(x, P, F, Q):
    return np.matmul(F, x), np.add(np.matmul(np.matmul(F, P), F.T), Q)


def corriger(x, P, z, H, R):
    n, m = len(x), len(z)
    A = np.vstack([np.eye(n), H])
    b = np.concatenate([x, z])
    C = np.block([[P, np.zeros((n, m))], [np.zeros((m, n)), R]])
    L = np.linalg.cholesky(C)
    A, b = np.linalg.solve(L, A), np.linalg.solve(L, b)
    solution = np.linalg.lstsq(A, b, rcond=None)[0]
    return solution, np.linalg.inv(A.T @ A)
