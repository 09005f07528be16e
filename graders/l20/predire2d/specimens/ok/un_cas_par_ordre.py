"""A branch for each order, written out; other parameter names; the maximum taken out before the exponential."""
HAUT, BAS, GAUCHE, DROITE = (-1, 0), (1, 0), (0, -1), (0, 1)


def predire2d(b, sens_x, sens_y):
    if sens_x == 1:
        issues = {DROITE: 0.8, (1, 1): 0.1, (-1, 1): 0.1}
    elif sens_x == -1:
        issues = {GAUCHE: 0.8, (1, -1): 0.1, (-1, -1): 0.1}
    elif sens_y == 1:
        issues = {BAS: 0.8, (1, 1): 0.1, (1, -1): 0.1}
    elif sens_y == -1:
        issues = {HAUT: 0.8, (-1, 1): 0.1, (-1, -1): 0.1}
    else:
        return b * 1.0
    nouveau = np.zeros(b.shape)
    for ligne in range(b.shape[0]):
        for colonne in range(b.shape[1]):
            for (dy, dx), p in issues.items():
                try:
                    if ligne + dy < 0 or colonne + dx < 0 or not libres[ligne + dy, colonne + dx]:
                        raise IndexError
                    nouveau[ligne + dy, colonne + dx] += p * b[ligne, colonne]
                except IndexError:
                    nouveau[ligne, colonne] += p * b[ligne, colonne]
    return nouveau


def corriger2d(b, z, ecart_type=0.5):
    e = np.full(b.shape, -1e300)
    for y in range(H):
        for x in range(W):
            if libres[y, x]:
                e[y, x] = -0.5 * np.sum(((z - lidar((x + 0.5, y + 0.5, 0.0), 4)) / ecart_type) ** 2)
    e = e - e[b > 0].max()
    p = np.where(b > 0, b * np.exp(np.minimum(e, 0)), 0.0)
    return p / p.sum()
