class Ronce:
    def __getattribute__(self, nom):
        raise SystemExit(nom)
def repondre(contexte):
    return {"note": Ronce()}
