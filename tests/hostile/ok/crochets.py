import atexit, builtins, sys, threading, weakref
class Objet:
    def __del__(self):
        raise SystemExit
def leve(*a, **k):
    raise KeyboardInterrupt
def repondre(contexte):
    objet = Objet()
    weakref.finalize(objet, leve)
    atexit.register(leve)
    for nom in ("excepthook", "unraisablehook", "displayhook", "breakpointhook"):
        setattr(sys, nom, leve)
    threading.excepthook = builtins.print = builtins.__import__ = builtins.open = leve
    del objet
    return "rien"
