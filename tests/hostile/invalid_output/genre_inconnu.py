import os
from outils import enfant, fil, trame
def repondre(contexte):
    os.write(fil(), trame(enfant()._token, 250, b"N"))
    return 1
