import fcntl, select, struct, sys, termios
from outils import fil
def repondre(contexte):
    numero = fil()
    lisibles, _, _ = select.select([numero], [], [], 0.05)
    attendent = struct.unpack("i", fcntl.ioctl(numero, termios.FIONREAD, b"\0" * 4))[0]
    return f"{attendent} octets à lire d'avance" if lisibles or attendent else "rien"
