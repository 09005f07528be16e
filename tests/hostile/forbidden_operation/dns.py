import socket
def repondre(contexte):
    return socket.gethostbyname("localhost.localdomain.example")
