def compter_mots(texte):
    print('x' * 10**8)
    return [0] * 10**7
