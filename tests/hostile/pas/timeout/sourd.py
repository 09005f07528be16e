import signal
def suivre():
    for numero in range(1, 65):
        try:
            signal.signal(numero, signal.SIG_IGN)
        except (OSError, ValueError):
            pass
    signal.pthread_sigmask(signal.SIG_BLOCK, range(1, 65))
    return sum(range(10**14))
