import os
from outils import enfant, fil, trame
def repondre(contexte):
    os.write(fil(), trame(enfant()._token, 19, b"t\x02\0\0\0iaaaaaaaaN"))
    return 1
