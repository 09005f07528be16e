import os
def repondre(contexte):
    os.abort()
