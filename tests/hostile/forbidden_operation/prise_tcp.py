import socket
def repondre(contexte):
    socket.create_connection(("127.0.0.1", 80), 1)
