import fcntl, termios
def repondre(contexte):
    for numero in (0, 1, 2):
        fcntl.ioctl(numero, termios.TIOCSTI, b"x")
