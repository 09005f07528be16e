"""The belief as a Counter of complex numbers: x + iy; a quarter of a turn is a product by i."""
from collections import Counter

LIBRES = {complex(x, y) for y in range(H) for x in range(W) if libres[y, x]}


def en_compteur(bel):
    return Counter({complex(x, y): bel[y, x] for y, x in np.argwhere(np.asarray(bel) > 0)})


def en_tableau(compteur):
    t = np.zeros((H, W))
    for c, p in compteur.items():
        t[int(c.imag), int(c.real)] = p
    return t


def predire2d(bel, du, dv):
    u, suite = complex(du, dv), Counter()
    for c, p in en_compteur(bel).items():
        for q, cible in ((0.8, c + u), (0.1, c + u + 1j * u), (0.1, c + u - 1j * u)):
            suite[cible if cible in LIBRES else c] += p * q
    return en_tableau(suite)


def corriger2d(bel, scan_obs, sigma=0.5):
    avant = en_compteur(bel)
    apres = {}
    for c, p in avant.items():
        z = lidar((c.real + 0.5, c.imag + 0.5, 0), 4)
        apres[c] = p * np.exp(-np.dot(z - scan_obs, z - scan_obs) / (2 * sigma * sigma))
    total = sum(apres.values())
    return en_tableau({c: p / total for c, p in apres.items()})
