def compter_mots(texte):
    return compter_mots(texte)
