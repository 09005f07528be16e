import select, signal
signal.pthread_sigmask(signal.SIG_BLOCK, range(1, 65))
def repondre(contexte):
    while True:
        select.select([], [], [], 3600)
