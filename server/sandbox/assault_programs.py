"""The programs of the probe, each of which tries to cross one wall.

``essai`` returns "" when it was stopped, else what it managed to do, in French. ``prepare`` belongs to an accomplice,
which runs in another session, open meanwhile.
"""

REACH = """
import os
def essai(chemin):
    for action in (lambda: open(chemin).close(), lambda: os.listdir("/")):
        try:
            action()
        except OSError:
            continue
        return "des fichiers hors des dossiers permis ont pu être lus"
    return ""
"""

READ = """
def essai(chemin):
    try:
        open(chemin).close()
    except OSError:
        return ""
    return "un fichier de la machine a pu être lu"
"""

CONNECT = """
import socket
def essai(port):
    try:
        socket.create_connection(("127.0.0.1", port), 2).close()
    except OSError:
        return ""
    return "une connexion a pu être ouverte"
"""

QUEUE = """
import ctypes
def essai(cle):
    return "une file de messages de la machine est ouverte" if ctypes.CDLL(None).msgget(cle, 0) >= 0 else ""
"""

SYSTEM_CALLS = """
import os, socket
def essai(_):
    for nom, action in (("socket", socket.socket), ("fork", os.fork), ("memfd", lambda: os.memfd_create("x"))):
        try:
            action()
        except PermissionError:
            continue
        if nom == "fork" and os.getpid() != PID:
            os._exit(0)
        return nom + " n'est pas refusé"
    return ""
PID = os.getpid()
"""

KILLED = """
import ctypes
def essai(_):
    ctypes.CDLL(None).ptrace(0, 0, 0, 0)
    return "ptrace n'est pas refusé"
"""

WRITE = """
import os
def essai(_):
    for dossier in ("/", "/tmp", "/dev", "/dev/shm", os.path.dirname(os.__file__)):
        try:
            os.close(os.open(dossier + "/canari", os.O_CREAT | os.O_WRONLY))
            os.unlink(dossier + "/canari")
        except OSError:
            continue
        return "un fichier a pu être écrit dans " + dossier
    return ""
"""

LEAVE = """
import os
def prepare(_):
    for dossier in (".", "/tmp", "/dev/shm", "/var/tmp"):
        try:
            open(dossier + "/laisse-par-un-autre", "w").close()
        except OSError:
            continue
"""

FIND = """
import os
def essai(_):
    for dossier in (".", "/tmp", "/dev/shm", "/var/tmp"):
        if os.path.exists(dossier + "/laisse-par-un-autre"):
            return "un fichier d'une autre copie a pu être lu dans " + os.path.realpath(dossier)
    return ""
"""

WAIT = """
def prepare(_):
    return None
"""

SIGNAL = """
import os
def essai(_):
    moi = os.getpid()
    for pid in (*range(1, 300), *range(max(1, moi - 300), moi + 300)):
        try:
            os.kill(pid, 0)
        except OSError:
            continue
        if pid != moi:
            return "un autre processus peut recevoir un signal"
    return ""
"""

KEYRING = """
import ctypes
libc = ctypes.CDLL(None, use_errno=True)
NUMEROS = {"x86_64": (248, 249), "aarch64": (217, 218)}
def appel(numero, *arguments):
    return libc.syscall(ctypes.c_long(numero), *arguments)
def essai(machine):
    trouve = appel(NUMEROS[machine][1], b"user", b"balise-canari", None, ctypes.c_long(-4))
    return "une clé laissée par une autre copie a été trouvée" if trouve >= 0 else ""
def prepare(machine):
    appel(NUMEROS[machine][0], b"user", b"balise-canari", b"x", ctypes.c_long(1), ctypes.c_long(-4))
"""

HOST = """
import os
def essai(machine):
    return "le nom de la machine est visible" if os.uname().nodename == machine else ""
"""

MEMORY = """
def essai(octets):
    try:
        bytearray(octets)
    except MemoryError:
        return ""
    return "la mémoire n'est pas bornée"
"""

RESIDENT = """
def essai(octets):
    morceaux = [b"x" * 1000000 for _ in range(octets // 1000000)]
    return "la mémoire occupée n'est pas bornée" if morceaux else ""
"""

FORK = """
import os
def essai(_):
    try:
        pid = os.fork()
    except OSError:
        return ""
    if pid == 0:
        os._exit(0)
    return "un processus a pu être créé"
"""

TIME = """
import signal, time
def essai(secondes):
    for numero in (signal.SIGPROF, signal.SIGALRM):
        signal.signal(numero, signal.SIG_IGN)
    while time.process_time() < secondes:
        pass
    return "le temps de calcul n'est pas borné"
"""

CAPABILITY = """
import ctypes, os
def essai(_):
    libc = ctypes.CDLL(None, use_errno=True)
    actions = {"sethostname": lambda: libc.sethostname(b"x", ctypes.c_size_t(1)) == 0,
               "mount": lambda: libc.mount(b"none", b"/home/eleve", b"tmpfs", 0, None) == 0}
    for nom, action in actions.items():
        if action():
            return nom + " a réussi"
    return ""
"""

ROOT = """
import os
def essai(_):
    for nom, action in {"setuid": lambda: os.setuid(0), "chroot": lambda: os.chroot("/")}.items():
        try:
            action()
        except OSError:
            continue
        return nom + " a réussi"
    return ""
"""

INSPECTION = """
import ctypes
def essai(_):
    libc = ctypes.CDLL(None)
    if libc.prctl(39, 0, 0, 0, 0) != 1:
        return "no_new_privs n'est pas posé"
    return "le processus est ouvert à l'inspection" if libc.prctl(3, 0, 0, 0, 0) != 0 else ""
"""

ENVIRONMENT = """
import ctypes, os
def essai(_):
    lit = ctypes.CDLL(None).getenv
    lit.restype = ctypes.c_char_p
    return "l'environnement de la machine est visible" if os.environ or lit(b"PATH") else ""
"""

DESCRIPTORS = """
import fcntl
def essai(_):
    ouverts = []
    for numero in range(4096):
        try:
            fcntl.fcntl(numero, fcntl.F_GETFD)
        except OSError:
            continue
        ouverts.append(numero)
    if ouverts == [0, 1, 2, 227, 228, 229, 230]:  # replies and asks of the course's functions, traceback, wire
        return ""
    return "des descripteurs restent ouverts : " + str(ouverts)
"""
