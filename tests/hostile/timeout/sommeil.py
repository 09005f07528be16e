import time
def repondre(contexte):
    time.sleep(3600)
