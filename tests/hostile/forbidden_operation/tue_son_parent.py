import os, signal
def repondre(contexte):
    os.kill(os.getppid(), signal.SIGKILL)
