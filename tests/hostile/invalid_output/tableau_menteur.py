import os, struct
from outils import enfant, fil, trame
def repondre(contexte):
    contenu = b"t\x02\0\0\0a\x0b\x02" + struct.pack("<II", 2**31, 2**31) + b"\0" * 64 + b"N"
    os.write(fil(), trame(enfant()._token, 19, contenu))
    return 1
