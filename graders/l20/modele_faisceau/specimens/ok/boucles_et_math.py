import math


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    total = 0.0
    for lu, prevu in zip(z, z_attendu):
        p = alpha[0] / (sigma * math.sqrt(2 * math.pi)) * math.exp(-0.5 * ((lu - prevu) / sigma) ** 2)
        if lu <= prevu:
            p += alpha[1] * lam * math.exp(-lam * lu)
        if lu == z_max:
            p += alpha[2]
        p += alpha[3] / z_max
        total += math.log(p)
    return total


def champ_distance(libres):
    H, W = libres.shape
    resultat = []
    for y in range(H):
        ligne = []
        for x in range(W):
            meilleur = float("inf")
            for j in range(H):
                for i in range(W):
                    if not libres[j][i]:
                        meilleur = min(meilleur, math.sqrt((x - i) ** 2 + (y - j) ** 2))
            ligne.append(meilleur)
        resultat.append(ligne)
    return resultat
