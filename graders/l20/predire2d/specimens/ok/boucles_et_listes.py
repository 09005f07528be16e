"""Plain loops, lists and a dictionary; nothing of numpy but what is given; other parameter names; prints."""
import math


def est_libre(ligne, colonne):
    return 0 <= ligne < H and 0 <= colonne < W and bool(libres[ligne, colonne])


def predire2d(croyance, pas_x, pas_y):
    if pas_x == 0 and pas_y == 0:
        return [list(ligne) for ligne in croyance]
    suite = {}
    for y in range(H):
        for x in range(W):
            p = float(croyance[y][x])
            if p == 0:
                continue
            for proba, cote in ((0.8, 0), (0.1, 1), (0.1, -1)):
                cible = (y + pas_y + cote * pas_x, x + pas_x + cote * pas_y)
                if not est_libre(*cible):
                    cible = (y, x)
                suite[cible] = suite.get(cible, 0.0) + proba * p
    print("somme", sum(suite.values()))
    return [[suite.get((y, x), 0.0) for x in range(W)] for y in range(H)]


def corriger2d(croyance, mesures, ecart_type=0.5):
    produit = [[0.0] * W for _ in range(H)]
    for y in range(H):
        for x in range(W):
            if libres[y, x]:
                vus = lidar((x + 0.5, y + 0.5, 0.0), 4)
                v = 1.0
                for z, vu in zip(mesures, vus):
                    v *= math.exp(-0.5 * ((z - vu) / ecart_type) ** 2) / (ecart_type * math.sqrt(2 * math.pi))
                produit[y][x] = v * croyance[y][x]
    total = sum(map(sum, produit))
    return [[p / total for p in ligne] for ligne in produit]
