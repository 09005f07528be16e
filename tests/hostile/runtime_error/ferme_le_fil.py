import os
from outils import fil
def repondre(contexte):
    os.close(fil())
    return 1
