import os
vraie = os.write
def repondre(contexte):
    os.write = lambda numero, donnees: vraie(numero, bytes(donnees)[::-1])
    return 1
