"""A* with the straight distance, cells as complex numbers, parents in an array."""

from heapq import heappop, heappush
from itertools import count


def gonfler(grille, rayon, resolution):
    return np.array(
        [
            [
                grille[i, j] == 0
                and all(abs(complex(i - a, j - b)) * resolution > rayon for a, b in zip(*np.nonzero(grille == 100)))
                for j in range(grille.shape[1])
            ]
            for i in range(grille.shape[0])
        ]
    )


def cout(chemin, couts):
    z = [complex(*c) for c in chemin]
    c = [couts[int(a.real), int(a.imag)] for a in z]
    return float(sum(abs(b - a) * (1 + (d + e) / 2) for a, b, d, e in zip(z, z[1:], c, c[1:])))


def planifier(permises, couts, depart, but):
    libre = {complex(i, j): couts[i, j] for i, j in np.argwhere(permises)}
    debut, fin = complex(*depart), complex(*but)
    if debut not in libre or fin not in libre:
        return []
    rang, g, parent = count(), {debut: 0.0}, {debut: None}
    tas = [(abs(fin - debut), next(rang), 0.0, debut)]
    while tas:
        _, _, deja, z = heappop(tas)
        if deja > g[z]:
            continue
        if z == fin:
            break
        for d in (1, -1, 1j, -1j, 1 + 1j, 1 - 1j, -1 + 1j, -1 - 1j):
            d = complex(d)
            v = z + d
            if v not in libre or z + d.real not in libre or z + 1j * d.imag not in libre:
                continue
            nouveau = deja + abs(d) * (1 + (libre[z] + libre[v]) / 2)
            if nouveau < g.get(v, np.inf):
                g[v], parent[v] = nouveau, z
                heappush(tas, (nouveau + abs(fin - v), next(rang), nouveau, v))
    if fin not in parent:
        return []
    suite = []
    z = fin
    while z is not None:
        suite.append((int(z.real), int(z.imag)))
        z = parent[z]
    return suite[::-1]
