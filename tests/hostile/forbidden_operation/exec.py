import os, sys
def repondre(contexte):
    os.execv(sys.executable or "/bin/sh", ["x"])
