"""Each fit by a minimiser over the angle alone, from the best of a few."""
from scipy.optimize import minimize_scalar


def icp(P, Q, R0, t0, n_iter=30):
    def mat(a):
        return np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])

    R, t, erreurs, avant = R0, t0, [], None
    for _ in range(n_iter):
        A = P @ R.T + t
        j = np.argmin(np.sum((A[:, None] - Q) ** 2, axis=2), axis=1)
        if avant is not None and np.array_equal(j, avant):
            break
        avant = j
        p, q = P - P.mean(0), Q[j] - Q[j].mean(0)
        cout = lambda a: np.sum((p @ mat(a).T - q) ** 2)
        debut = min(np.linspace(-3.1, 3.1, 30), key=cout)
        a = minimize_scalar(cout, bounds=(debut - 0.3, debut + 0.3), method="bounded", options={"xatol": 1e-12}).x
        pas = 1e-3
        a -= pas * (cout(a + pas) - cout(a - pas)) / 2 / (cout(a + pas) - 2 * cout(a) + cout(a - pas))
        R = mat(a)
        t = Q[j].mean(0) - R @ P.mean(0)
        erreurs.append(np.sum((P @ R.T + t - Q[j]) ** 2))
    return R, t, erreurs
