# Des sous-classes des types de base : elles ne sont pas ce dont elles ont l'air.
import numpy as np
from collections import deque
def dit(*_, **__):
    print("touché")
    return 1
def fait(base, *donne):
    noms = """__repr__ __str__ __eq__ __ne__ __len__ __iter__ __getitem__ __bool__ __float__ __index__ bit_length
    items keys values item tobytes tolist astype encode is_integer __array_finalize__ __array_wrap__ flat""".split()
    return type(base.__name__, (base,), dict.fromkeys(noms, dit) | {"__hash__": lambda _: 1})(*donne)
def suivre():
    entier = fait(int, 3)
    flottant = fait(float, 3.0)
    complexe = fait(complex, 1j)
    texte = fait(str, "abc")
    liste = fait(list, (1, 2))
    couple = fait(tuple, (1, 2))
    dico = fait(dict, {"a": 1})
    ensemble = fait(set, (1, 2))
    file = fait(deque, (1, 2))
    tableau = np.zeros(3).view(type("Tableau", (np.ndarray,), {"tolist": dit, "tobytes": dit, "flat": property(dit)}))
    return "rien"
