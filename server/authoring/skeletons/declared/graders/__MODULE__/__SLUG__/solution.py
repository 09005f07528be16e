def __SLUG__(texte):
    comptes = {}
    for mot in texte.split():
        comptes[mot] = comptes.get(mot, 0) + 1
    return comptes
