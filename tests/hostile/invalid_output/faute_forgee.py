import os
from outils import enfant, fil, trame
def repondre(contexte):
    os.write(fil(), trame(enfant()._token, 20, b"d\x01\0\0\0s\x04\0\0\0kinds\x02\0\0\0ok"))
    return 1
