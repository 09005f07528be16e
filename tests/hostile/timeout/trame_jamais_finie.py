import os, signal, time
from outils import enfant, fil, trame
def repondre(contexte):
    os.write(fil(), trame(enfant()._token, 19, b"", longueur=1000))
    signal.setitimer(signal.ITIMER_REAL, 0)
    time.sleep(3600)
