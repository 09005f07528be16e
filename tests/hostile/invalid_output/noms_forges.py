import os
from outils import enfant, fil, trame
noms = b"".join(b"s\x17\0\0\0repondra%015d" % k for k in range(4000))
os.write(fil(), trame(enfant()._token, 19, b"t" + (4000).to_bytes(4, "little") + noms))
def repondre(contexte):
    return "rien"
