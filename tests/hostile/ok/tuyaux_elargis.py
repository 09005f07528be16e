import fcntl, os
def repondre(contexte):
    total = 0
    for _ in range(contexte["files"]):
        try:
            lit, ecrit = os.pipe()
        except OSError:
            break
        os.set_blocking(ecrit, False)
        try:
            fcntl.fcntl(ecrit, 1031, 1 << 20)
        except OSError:
            pass
        try:
            while True:
                total += os.write(ecrit, bytes(1 << 16))
        except OSError:
            pass
    return "rien" if total <= contexte["files"] << 16 else f"{total} octets dans des tuyaux"
