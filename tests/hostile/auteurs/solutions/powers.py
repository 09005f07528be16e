x = 9 ** 9 ** 9 ** 9
def compter_mots(texte):
    return {}
