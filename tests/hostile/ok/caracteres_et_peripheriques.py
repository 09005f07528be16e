import os, stat
def repondre(contexte):
    faits = []
    for chemin in ("/dev/kmsg", "/dev/mem", "/dev/kvm", "/dev/fuse", "/dev/net/tun", "/dev/tty", "/dev/ptmx", "/dev/console", "/dev/sda", "/dev/loop-control", "/dev/shm"):
        try:
            os.close(os.open(chemin, os.O_RDONLY))
        except OSError:
            continue
        faits.append(chemin)
    for nom, genre, numeros in (("noeud", stat.S_IFCHR, (1, 1)), ("bloc", stat.S_IFBLK, (8, 0)), ("nul", stat.S_IFCHR, (1, 3))):
        try:
            os.mknod(nom, 0o600 | genre, os.makedev(*numeros))
        except OSError:
            continue
        faits.append(nom)
    return str(faits) if faits else "rien"
