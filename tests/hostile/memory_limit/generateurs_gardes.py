def generateur():
    while True:
        yield bytearray(1 << 16)
def repondre(contexte):
    gardes = []
    while True:
        gardes.append(generateur())
        gardes.append(next(gardes[-1]))
