import numpy as np
def suivre():
    entier = 1 << 4_000_000
    texte = "é" * 2_000_000
    dico = dict.fromkeys(range(200_000))
    liste = [[0] * 1000] * 1000
    plage = range(-10**100, 10**100)
    tableau = np.zeros((1000, 1000))
    vides = np.zeros((10**9, 0, 5))
    large = np.broadcast_to(np.float64(1), (10**4, 10**4))
    for k in range(5):
        tableau[k, k] = k
        dico[k] = k
    return "rien"
