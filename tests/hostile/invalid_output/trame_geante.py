import os
from outils import enfant, fil, trame
def repondre(contexte):
    os.write(fil(), trame(enfant()._token, 19, b"x" * 1000, longueur=2**32 - 1))
    return 1
