import os
from outils import fil
def repondre(contexte):
    os.dup2(1, fil())
    return "rien"
