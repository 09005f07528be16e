import os
from outils import fil, trame
for jeton in (0, 1, 2):
    os.write(fil(), trame(jeton, 19, b"N"))
def repondre(contexte):
    return 1
