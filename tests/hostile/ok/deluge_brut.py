import os
def repondre(contexte):
    morceau = b"x" * 65536
    for numero in (1, 2):
        for _ in range(2000):
            try:
                os.write(numero, morceau)
            except OSError:
                break
    for action in (lambda: os.ftruncate(1, 1 << 40), lambda: os.posix_fallocate(1, 0, 1 << 40), lambda: os.pwrite(1, b"x", 1 << 40)):
        try:
            action()
        except OSError:
            continue
        return "la sortie a grandi"
    os.lseek(1, 1 << 40, 0)
    return "rien"
