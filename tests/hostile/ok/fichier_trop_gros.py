import os
def repondre(contexte):
    try:
        numero = os.open("gros", os.O_CREAT | os.O_RDWR, 0o600)
    except OSError:
        return "rien"
    for action in (lambda: os.pwrite(numero, b"x", contexte["file_bytes"] + 1), lambda: os.ftruncate(numero, contexte["file_bytes"] + 1),
                   lambda: os.posix_fallocate(numero, 0, contexte["file_bytes"] + 1)):
        try:
            action()
        except OSError:
            continue
        return "un fichier a dépassé sa borne"
    return "rien"
