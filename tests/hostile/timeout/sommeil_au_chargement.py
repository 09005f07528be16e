import time
time.sleep(3600)
def repondre(contexte):
    return 1
