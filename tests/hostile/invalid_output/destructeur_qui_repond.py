import os
from outils import enfant, fil, trame
class Testament:
    def __del__(self):
        os.write(fil(), trame(jeton, 19, b"t\2\0\0\0TN"))
def repondre(contexte):
    global jeton
    jeton = enfant()._token
    Testament()
    return 1
