import ctypes, mmap, os
def repondre(contexte):
    try:
        with open("charge.so", "wb") as fichier:
            fichier.write(b"\x7fELF" + bytes(4092))
        os.chmod("charge.so", 0o700)
    except OSError:
        return "rien"
    with open("charge.so", "rb") as fichier:
        try:
            mmap.mmap(fichier.fileno(), 4096, flags=mmap.MAP_PRIVATE, prot=mmap.PROT_READ | mmap.PROT_EXEC)
        except OSError:
            return "rien"
    return "du code écrit par le programme a été projeté pour être exécuté"
