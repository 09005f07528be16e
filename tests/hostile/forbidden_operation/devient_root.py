import os
def repondre(contexte):
    os.setuid(0)
