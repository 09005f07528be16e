import os
def repondre(contexte):
    places, total = (".", "/tmp", "/dev/shm", "/var/tmp", "/home"), 0
    for place in places:
        for k in range(5000):
            try:
                with open(f"{place}/fichier{k}", "wb", buffering=0) as fichier:
                    total += fichier.write(bytes(1 << 16))
            except OSError:
                break
    borne = max(contexte["file_bytes"], contexte.get("folder_bytes", 0))
    return "rien" if total <= borne else f"{total} octets écrits"
