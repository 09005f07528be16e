import os
from outils import enfant, fil, trame
def repondre(contexte):
    os.write(fil(), trame(enfant()._token, 19, b"l\x01\0\0\0" * 50000 + b"N"))
    return 1
