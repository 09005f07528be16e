import gc
class Fin:
    def __init__(self, liste):
        self.moi, self.liste = self, liste
    def __del__(self):
        self.liste.clear()
        globals().pop("a", None)
def suivre():
    gc.set_threshold(1)
    liste = list(range(100))
    for k in range(20):
        Fin(liste)
        liste.append({k: [k]})
        globals()["a"] = k
    gc.set_threshold(700)
    return "rien"
