import os
def repondre(contexte):
    ouverts = []
    try:
        while len(ouverts) < 4096:
            ouverts += os.pipe()
    except OSError:
        pass
    for numero in ouverts:
        os.close(numero)
    return "rien" if len(ouverts) <= contexte["files"] else f"{len(ouverts)} descripteurs"
