distance_et_jacobien = lambda x, balise: (np.hypot(*(x - balise)), (x - balise) / np.hypot(*(x - balise)))
gain = lambda P, H, r: P @ H / (H @ P @ H + r)
avec = lambda x, P, z, d, H, K: (x - K * (d - z), (np.eye(2) - np.outer(K, H)) @ P)
corriger_distance = lambda x, P, z, b, r: avec(x, P, z, *distance_et_jacobien(x, b), gain(P, distance_et_jacobien(x, b)[1], r))
