import transformee_rapide


def signature(scan):
    return transformee_rapide.spectre(scan)


def candidats_boucle(scans, i, seuil):
    return []
