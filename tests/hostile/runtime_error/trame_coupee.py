import os
from outils import enfant, fil, trame
def repondre(contexte):
    os.write(fil(), trame(enfant()._token, 19, b"x" * 10)[:-3])
    os._exit(0)
