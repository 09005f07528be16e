enorme = bytearray(1 << 44)
def repondre(contexte):
    return 1
