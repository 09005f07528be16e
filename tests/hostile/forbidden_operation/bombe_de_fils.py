import threading
def repondre(contexte):
    while True:
        threading.Thread(target=lambda: threading.Event().wait()).start()
