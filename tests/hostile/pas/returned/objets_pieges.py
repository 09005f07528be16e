# Aucune méthode de ces objets ne doit être appelée par qui les regarde : elles le diraient.
def piege(nom):
    def dit(*_, **__):
        print("touché :", nom)
        raise RuntimeError
    return dit
NOMS = """__repr__ __str__ __eq__ __ne__ __hash__ __len__ __iter__ __getitem__ __bool__ __float__ __int__ __index__
__array__ __array_interface__ __format__ __getattribute__ __contains__ __reversed__ __dir__ __sizeof__ __reduce_ex__
__instancecheck__ __subclasscheck__ __complex__ __abs__ __lt__ __gt__ __missing__""".split()
PIEGES = {nom: piege(nom) for nom in NOMS}
class Meta(type):
    __hash__ = __eq__ = __getattribute__ = __repr__ = __instancecheck__ = __subclasscheck__ = piege("type")
    __name__ = __mro__ = __dict__ = property(piege("attribut du type"))
Objet = Meta("Objet", (), dict(PIEGES, __class__=property(piege("__class__"))))
def suivre():
    nu = Objet()
    liste = [nu]
    doublon = (nu, liste)
    dico = {1: nu}
    del nu
    return "rien"
