import socket
def repondre(contexte):
    prise = socket.socket(socket.AF_UNIX)
    prise.bind("\0rendez-vous")
