class Texte(str):
    __eq__ = __ne__ = startswith = __getitem__ = __hash__ = lambda *_: print("touché")
def g():
    return 1
def suivre():
    for champ in ("co_filename", "co_name", "co_qualname"):
        try:
            g.__code__ = g.__code__.replace(**{champ: Texte("solution.py")})
        except (TypeError, ValueError, SystemError):
            pass
    try:
        g.__name__ = Texte("g")
        type("A", (), {}).__name__ = Texte("A")
    except TypeError:
        pass
    h = g
    return "rien"
