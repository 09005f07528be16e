import socket
def repondre(contexte):
    socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, 0)
