"""Moments of the distances and of their differences round the circle."""


def signature(scan):
    pas = np.diff(np.append(scan, scan[0]))
    centre = scan - scan.mean()
    return np.array([scan.mean(), *(np.cbrt(np.mean(centre**3)), np.sqrt(np.mean(centre**2))),
                     np.mean(np.abs(pas)), np.sqrt(np.mean(pas**2)), np.mean(np.abs(pas - np.roll(pas, 1)))])


def candidats_boucle(scans, i, seuil):
    toutes = np.array([signature(s) for s in scans[: i + 1]])
    ecarts = np.linalg.norm(toutes - toutes[i], axis=1)
    return [int(j) for j in np.where(ecarts <= seuil)[0] if j <= i - 10]
