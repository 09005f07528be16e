import os
from outils import enfant, fil, trame
def repondre(contexte):
    os.write(fil(), trame(enfant()._token, 19, b"l" + b"\xff" * 4 + b"N" * 100))
    return 1
