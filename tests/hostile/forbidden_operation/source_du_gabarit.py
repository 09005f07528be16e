import os
def repondre(contexte):
    return open(contexte["gabarit"]).read()
