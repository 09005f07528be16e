def compter_mots(texte):
    while True:
        pass
