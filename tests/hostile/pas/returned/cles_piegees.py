class Cle:
    def __init__(self, nom):
        self.nom, self.sage = nom, True
    def __hash__(self):
        self.sage or print("touché")
        return hash(self.nom)
    def __eq__(self, autre):
        self.sage or print("touché")
        return self is autre
def suivre():
    cles = [Cle("a"), Cle("kind"), Cle("x"), Cle("__name__")]
    dico = {cle: 1 for cle in cles}
    ensemble = set(cles)
    globals().update({cle: 2 for cle in cles})
    for cle in cles:
        cle.sage = False
    y = 1
    for cle in cles:
        cle.sage = True
    return "rien"
