import ctypes, os
from outils import fil
def repondre(contexte):
    libc, numero, tampon = ctypes.CDLL(None), fil(), ctypes.create_string_buffer(64)
    essais = {
        "send hors bande": lambda: libc.send(numero, b"x", 1, 1),
        "sendmsg": lambda: libc.sendmsg(numero, tampon, 0),
        "recvmsg": lambda: libc.recvmsg(numero, tampon, 0x42),
        "recv en avance": lambda: libc.recv(numero, tampon, 64, 0x42),
        "shutdown": lambda: libc.shutdown(numero, 1),
        "getpeername": lambda: libc.getpeername(numero, tampon, tampon),
        "setsockopt": lambda: libc.setsockopt(numero, 1, 8, tampon, 4),
        "sendmmsg": lambda: libc.sendmmsg(numero, tampon, 1, 0),
        "splice": lambda: libc.splice(numero, None, 1, None, 1, 0),
        "sendfile": lambda: libc.sendfile(numero, 1, None, 1) if contexte["parent"] < 0 else -1,
    }
    reussis = [nom for nom, essai in essais.items() if essai() >= 0]
    return str(reussis) if reussis else "rien"
