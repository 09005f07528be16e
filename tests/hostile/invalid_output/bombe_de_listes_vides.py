import os
from outils import enfant, fil, trame
def repondre(contexte):
    combien = contexte["items"] * 4
    contenu = b"t\2\0\0\0l" + combien.to_bytes(4, "little") + b"d\0\0\0\0" * combien + b"N"
    os.write(fil(), trame(enfant()._token, 19, contenu))
    return 1
