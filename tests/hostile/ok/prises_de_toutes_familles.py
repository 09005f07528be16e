import socket, itertools
FAMILLES = ("AF_INET", "AF_INET6", "AF_UNIX", "AF_NETLINK", "AF_PACKET", "AF_VSOCK", "AF_ALG", "AF_CAN", "AF_BLUETOOTH", "AF_TIPC", "AF_RDS", "AF_QIPCRTR")
def repondre(contexte):
    ouvertes = []
    for famille, genre in itertools.product([*(int(getattr(socket, nom, 1)) for nom in FAMILLES), 9, 11, 15, 24, 44], (1, 2, 3, 5)):
        try:
            socket.socket(famille, genre)
        except OSError:
            continue
        ouvertes.append((famille, genre))
    try:
        socket.socketpair()
        ouvertes.append("socketpair")
    except OSError:
        pass
    return str(ouvertes) if ouvertes else "rien"
