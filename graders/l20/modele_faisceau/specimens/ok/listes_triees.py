import bisect
import statistics


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    logs = []
    for i in range(len(z)):
        cloche = statistics.NormalDist(z_attendu[i], sigma).pdf(z[i])
        court = lam * np.exp(-lam * z[i]) if not z[i] > z_attendu[i] else 0
        plein = 1 if not z[i] < z_max else 0
        logs.append(np.log(np.dot(alpha, [cloche, court, plein, 1 / z_max])))
    return sum(logs)


def champ_distance(libres):
    def d2(murs_de_la_ligne, x):
        k = bisect.bisect(murs_de_la_ligne, x)
        return min((abs(x - m) for m in murs_de_la_ligne[max(0, k - 1):k + 1]), default=10**6) ** 2

    lignes = [np.flatnonzero(~ligne).tolist() for ligne in libres]
    h, w = libres.shape
    return np.array([[min((y - j) ** 2 + d2(lignes[j], x) for j in range(h)) for x in range(w)] for y in range(h)]) ** 0.5
