import os
def repondre(contexte):
    os.setsid()
    if os.fork():
        os._exit(0)
