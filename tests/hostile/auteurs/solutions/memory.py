x = bytearray(4 << 30)
def compter_mots(texte):
    return {}
