import os
lit, ecrit = os.pipe()
def repondre(contexte):
    return os.read(lit, 1)
