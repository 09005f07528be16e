import numpy as np
def suivre():
    liste = []
    liste.append(liste)
    dico = {}
    dico["moi"] = dico
    couple = (liste, dico)
    liste += [couple] * 50
    objets = np.empty(3, dtype=object)
    objets[:] = [objets, liste, dico]
    profond = []
    for _ in range(40):
        profond = [profond]
    return "rien"
