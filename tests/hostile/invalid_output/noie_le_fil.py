import os
from outils import fil
def repondre(contexte):
    numero = fil()
    while True:
        os.write(numero, b"\0" * 65536)
