import os, time
def repondre(contexte):
    for numero in range(3, 1024):
        try:
            os.close(numero)
        except OSError:
            pass
    time.sleep(3600)
