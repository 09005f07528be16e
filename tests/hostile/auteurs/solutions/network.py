import socket
socket.create_connection(('127.0.0.1', 22), 1)
def compter_mots(texte):
    return {}
