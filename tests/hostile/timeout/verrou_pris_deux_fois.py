import threading
verrou = threading.Lock()
def repondre(contexte):
    while verrou.acquire():
        pass
