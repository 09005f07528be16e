class Meta(type):
    __name__ = property(lambda _: print("touché : nom"))
    __hash__ = lambda _: print("touché : hash") or 1
class Piege(Exception, metaclass=Meta):
    args = property(lambda _: print("touché : args"))
    __str__ = __repr__ = lambda _: print("touché : texte") or "x"
    __getattribute__ = lambda _, nom: print("touché :", nom)
class Longue(Exception):
    pass
def suivre():
    for fabrique in (Piege, lambda: Longue("x" * 10**6), lambda: Longue(10**50_000), lambda: KeyError([1] * 10**5)):
        try:
            raise fabrique()
        except Exception:
            pass
    return "rien"
