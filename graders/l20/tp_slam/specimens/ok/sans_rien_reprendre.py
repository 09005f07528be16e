# Rien de mes_fonctions : tableaux de distances, nombres complexes, moindres carrés à la main.
def vers(z):
    return np.array([z[0].real, z[0].imag, np.angle(z[1])])


def de(p):
    return complex(p[0], p[1]), np.exp(1j * p[2])


def fois(a, b):
    return a[0] + a[1] * b[0], a[1] * b[1]


def vu_de(a, b):
    return (b[0] - a[0]) * np.conj(a[1]), b[1] * np.conj(a[1])


def trajectoire(roues, L):
    p, liste = (0j, 1 + 0j), []
    liste.append(vers(p))
    for g, d in roues:
        demi = np.exp(1j * (d - g) / (2 * L))
        p = fois(p, ((g + d) / 2 * demi, demi * demi))
        liste.append(vers(p))
    return liste


def poses_cles(poses):
    gardes, reste = [0], list(enumerate(map(de, poses)))[1:]
    dernier = de(poses[0])
    for k, p in reste:
        z, u = vu_de(dernier, p)
        if abs(z) >= 0.3 or abs(np.angle(u)) >= 0.4:
            gardes.append(k)
            dernier = p
    return np.array(gardes)


def recaler(points_a, points_b, depart):
    a, b = points_a[:, 0] + 1j * points_a[:, 1], points_b[:, 0] + 1j * points_b[:, 1]
    t, u = de(depart)
    for _ in range(40):
        q = t + u * b
        d = np.abs(q[:, None] - a[None, :])
        j = d.argmin(axis=1)
        ok = d[np.arange(len(q)), j] < 0.3
        if ok.sum() < 3:
            return vers((t, u)), 0
        x, y = b[ok], a[j[ok]]
        s = np.vdot(x - x.mean(), y - y.mean())
        u = s / abs(s)
        t = y.mean() - u * x.mean()
    d = np.abs((t + u * b)[:, None] - a[None, :]).min(axis=1)
    return vers((t, u)), (d < 0.1).sum() / len(d)


def fermetures(scans, chaine):
    n = scans.shape[1]
    tour = np.exp(2j * np.pi * np.arange(n) / n)
    f = np.abs(np.fft.fft(scans))[:, :8] / n
    nuages = []
    for s in scans:
        z = (s * tour)[s < 8]
        nuages.append(np.column_stack([z.real, z.imag]))
    poses, sorties = [de(p) for p in chaine], []
    for b in range(20, len(scans)):
        proches = [a for a in range(b - 19) if np.linalg.norm(f[a] - f[b]) < 0.15 and abs(poses[a][0] - poses[b][0]) < 1.5]
        for a in proches:
            p, part = recaler(nuages[a], nuages[b], vers(vu_de(poses[a], poses[b])))
            if part > 0.85:
                sorties.append([a, b, p.tolist()])
    return sorties


def optimiser(chaine, recalages, deplacements, boucles):
    from scipy.optimize import least_squares

    n = len(chaine)
    aretes = [(k, k + 1, z, 0.02, 0.01) for k, z in enumerate(recalages)]
    aretes += [(k, k + 1, z, 0.03, 0.05) for k, z in enumerate(deplacements)]
    aretes += [(a, b, z, 0.03, 0.015) for a, b, z in boucles]
    i, j = np.array([e[0] for e in aretes]), np.array([e[1] for e in aretes])
    z = np.array([e[2] for e in aretes], dtype=float)
    s, sa = np.array([e[3] for e in aretes]), np.array([e[4] for e in aretes])

    def ecarts(v):
        x = np.vstack([chaine[:1], v.reshape(-1, 3)])
        c, si = np.cos(x[i, 2]), np.sin(x[i, 2])
        d = x[j] - x[i]
        ex, ey = c * d[:, 0] + si * d[:, 1] - z[:, 0], -si * d[:, 0] + c * d[:, 1] - z[:, 1]
        ea = (d[:, 2] - z[:, 2] + np.pi) % (2 * np.pi) - np.pi
        return np.concatenate([ex / s, ey / s, ea / sa])

    from scipy.sparse import lil_matrix

    motif = lil_matrix((3 * len(aretes), 3 * (n - 1)), dtype=int)
    for k in range(len(aretes)):
        for p in (i[k], j[k]):
            if p:
                for bloc in range(3):
                    motif[k + bloc * len(aretes), 3 * (p - 1) : 3 * p] = 1
    v = least_squares(ecarts, np.asarray(chaine)[1:].ravel(), jac_sparsity=motif, method="trf").x
    return np.vstack([chaine[:1], v.reshape(-1, 3)])


def carte(poses, scans, forme, origine, cote, portee=8.0):
    total = np.zeros(forme)
    n = scans.shape[1]
    for (x, y, theta), scan in zip(poses, scans):
        angles = theta + 2 * np.pi * np.arange(n) / n
        for r, angle in zip(scan, angles):
            pas = np.arange(0.0, r, cote / 4)
            ligne = np.floor((y + pas * np.sin(angle) - origine[1]) / cote).astype(int)
            colonne = np.floor((x + pas * np.cos(angle) - origine[0]) / cote).astype(int)
            fin = None
            if r < portee:
                fin = (
                    int(np.floor((y + (r + 1e-6) * np.sin(angle) - origine[1]) / cote)),
                    int(np.floor((x + (r + 1e-6) * np.cos(angle) - origine[0]) / cote)),
                )
            for case in set(zip(ligne.tolist(), colonne.tolist())) - {fin}:
                total[case] = max(total[case] - 0.847, -5)
            if fin:
                total[fin] = min(total[fin] + 0.847, 5)
    return total.tolist()
