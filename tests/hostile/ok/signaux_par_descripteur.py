import fcntl, os, signal
def repondre(contexte):
    lit, ecrit = os.pipe()
    reussis = []
    for cible in (1, os.getppid(), contexte["parent"], -contexte["parent"]):
        for action in (lambda: fcntl.fcntl(lit, fcntl.F_SETOWN, cible), lambda: fcntl.fcntl(lit, 10, signal.SIGKILL)):
            try:
                action()
            except OSError:
                continue
            reussis.append(cible)
        fcntl.fcntl(lit, fcntl.F_SETFL, os.O_ASYNC | os.O_NONBLOCK)
        os.write(ecrit, b"x")
    os.close(lit)
    os.close(ecrit)
    return f"F_SETOWN : {reussis}" if reussis else "rien"
