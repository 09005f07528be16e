import importlib, sys
def repondre(contexte):
    while True:
        for nom in ("json", "email", "html", "decimal", "fractions"):
            for module in [m for m in sys.modules if m.partition(".")[0] == nom]:
                del sys.modules[module]
            importlib.import_module(nom)
