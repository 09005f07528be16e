ECART = 10  # en deçà, deux scans se ressemblent parce que le robot a peu bougé


def signature(scan):
    """Les amplitudes de la transformée de Fourier du scan : tourner sur place n'en change que les phases."""
    return np.abs(np.fft.rfft(scan))


def candidats_boucle(scans, i, seuil):
    """Les indices j ≤ i − 10 dont la signature est à une distance d'au plus `seuil` de celle du scan i."""
    # La signature du scan i ne se calcule qu'une fois.
    reference = signature(scans[i])
    candidats = []
    # range s'arrête juste avant sa borne : le dernier j est bien i − 10. Si i < 10, la boucle est vide.
    for j in range(i - ECART + 1):
        # Distance euclidienne entre les deux signatures.
        if np.linalg.norm(signature(scans[j]) - reference) <= seuil:
            candidats.append(j)
    return candidats
