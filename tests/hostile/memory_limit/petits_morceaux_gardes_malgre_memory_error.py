garde = []
def repondre(contexte):
    taille = 1 << 24
    while taille:
        try:
            garde.append(bytearray(taille))
        except MemoryError:
            taille //= 2
    while True:
        garde.append(bytearray(100))
