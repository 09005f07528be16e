"""Programs by which two students would meet: what one leaves, the other looks for.

Each channel is a program run twice, by two students: ``laisse()`` in the first session, then ``regarde(laissé)`` in the
second, then ``constate()`` in the first if it still stands. The last two list what they found. A program may also be
killed for trying: that is a way of finding nothing.
"""

from __future__ import annotations

PRELUDE = """
import ctypes, mmap, os, platform, sys
libc = ctypes.CDLL(None, use_errno=True)
libc.mmap.restype = ctypes.c_void_p
libc.fcntl.argtypes = [ctypes.c_int, ctypes.c_int, ctypes.c_void_p]
F_SETFL, F_SETLK, F_SETOWN, F_SETSIG, F_OFD_SETLK, F_SETLEASE, LOCK_EX_NB = 4, 6, 8, 10, 37, 1024, 6
def appel(fonction, *arguments):
    if fonction(*arguments) == -1:
        raise OSError(ctypes.get_errno(), "")
X86 = platform.machine() == "x86_64"
MARQUE = "rendez-vous-3141592"
def tente(*actions):
    reussies = []
    for action in actions:
        try:
            reussies.append(action())
        except (OSError, ValueError, ImportError, AttributeError, OverflowError, LookupError):
            pass
    return reussies
def constate():
    return []
"""

CHANNELS = {
    "fichiers": """
import numpy
DOSSIERS = [".", "..", "/", "/tmp", "/var/tmp", "/dev", "/dev/shm", "/home", "/home/eleve", "/run", "/proc/self/cwd",
            os.path.dirname(os.__file__), os.path.dirname(numpy.__file__) + "/__pycache__"]
def ecrit(dossier):
    with open(f"{dossier}/{MARQUE}", "w") as fichier:
        fichier.write(MARQUE)
def laisse():
    tubes = (lambda: os.mkfifo(MARQUE), lambda: os.mkdir("/dev/shm/" + MARQUE))
    return len(tente(*(lambda d=d: ecrit(d) for d in DOSSIERS), *tubes))
def regarde(_):
    noms = [nom for d in DOSSIERS for liste in tente(lambda: os.listdir(d)) for nom in liste if nom == MARQUE]
    return noms + tente(*(lambda d=d: os.stat(f"{d}/{MARQUE}").st_size for d in DOSSIERS))
""",
    "place-du-dossier": """
def laisse():
    return len(tente(*(lambda k=k: open(f"f{k}", "wb").write(bytes(1 << 16)) for k in range(20))))
def regarde(_):
    occupees = [v.f_files - v.f_ffree for v in tente(lambda: os.statvfs("."))]
    return tente(lambda: os.listdir("."))[0:1] if occupees and os.listdir(".") else []
""",
    "memoire-partagee": """
def laisse():
    tente(lambda: os.open("/dev/shm/" + MARQUE, os.O_CREAT | os.O_RDWR))
    return [libc.shmget(3141, 4096, 0o1666), libc.semget(3141, 1, 0o1666), libc.msgget(3141, 0o1666)]
def regarde(_):
    vus = [n for n in (libc.shmget(3141, 0, 0), libc.semget(3141, 0, 0), libc.msgget(3141, 0)) if n >= 0]
    return vus + tente(lambda: os.stat("/dev/shm/" + MARQUE).st_size)
""",
    "files-posix": """
NUMERO = 240 if X86 else 180
def ouvre(drapeaux):
    return libc.syscall(NUMERO, MARQUE.encode(), drapeaux, 0o666, None)
def laisse():
    return ouvre(os.O_CREAT | os.O_RDWR)
def regarde(_):
    return [n for n in (ouvre(os.O_RDWR),) if n >= 0]
""",
    "prises-unix": """
import socket
NOMS = ["\\0" + MARQUE, MARQUE, "/tmp/" + MARQUE]
gardees = []
def ecoute(nom):
    prise = socket.socket(socket.AF_UNIX)
    prise.bind(nom)
    prise.listen()
    gardees.append(prise)
def laisse():
    return len(tente(*(lambda n=n: ecoute(n) for n in NOMS)))
def regarde(_):
    return tente(*(lambda n=n: str(socket.socket(socket.AF_UNIX).connect(n)) for n in NOMS))
""",
    "reseau-local": """
import socket
gardees = []
def ouvre(methode):
    prise = socket.socket()
    getattr(prise, methode)((b"127.0.0.1", 31415))
    return prise
def laisse():
    gardees.extend(tente(lambda: ouvre("bind")))
    for prise in gardees:
        prise.listen()
    return len(gardees)
def regarde(_):
    return [1 for _ in tente(lambda: ouvre("connect"))]
""",
    "signaux": """
import signal
recus = []
for numero in (signal.SIGUSR1, signal.SIGIO, signal.SIGURG):
    signal.signal(numero, lambda n, cadre: recus.append(n))
def laisse():
    return os.getpid()
def regarde(pid):
    lit, ecrit = os.pipe()
    os.set_blocking(lit, False)
    for cible in (pid, pid + 1, pid - 1, -1, -pid):
        tente(lambda: os.kill(cible, signal.SIGUSR1) if cible != os.getpid() else None,
              lambda: signal.pidfd_send_signal(os.pidfd_open(cible), signal.SIGUSR1),
              lambda: appel(libc.fcntl, lit, F_SETOWN, cible), lambda: appel(libc.fcntl, lit, F_SETSIG, signal.SIGUSR1),
              lambda: appel(libc.fcntl, lit, F_SETFL, os.O_ASYNC | os.O_NONBLOCK), lambda: os.write(ecrit, b"x"))
    return []
def constate():
    return [int(n) for n in recus]
""",
    "processus": """
def laisse():
    return os.getpid()
def regarde(pid):
    vus = []
    for autre in {*range(1, 400), pid} - {os.getpid(), os.getpgrp(), os.getsid(0)}:
        vus += tente(lambda: os.getpgid(autre), lambda: os.getsid(autre), lambda: len(os.sched_getaffinity(autre)),
                     lambda: os.getpriority(os.PRIO_PROCESS, autre), lambda: str(os.kill(autre, 0)),
                     lambda: os.pidfd_open(autre), lambda: os.listdir(f"/proc/{autre}"))
    return vus
""",
    "memoire-d-un-autre": """
secret = ctypes.create_string_buffer(MARQUE.encode())
def laisse():
    return [os.getpid(), ctypes.addressof(secret)]
def regarde(ou):
    pid, adresse = ou
    lus = tente(lambda: open(f"/proc/{pid}/mem", "rb").read(1).hex())
    if pid != os.getpid():
        libc.ptrace(16, pid, 0, 0)
    tampon, vers = ctypes.create_string_buffer(8), (ctypes.c_size_t * 2)()
    vers[:] = ctypes.addressof(tampon), 8
    libc.process_vm_readv(pid + 1, vers, 1, (ctypes.c_size_t * 2)(adresse, 8), 1, 0)
    return [*lus, "process_vm_readv est passé"]
""",
    "projections": """
import numpy
gardees = []
def projette(chemin):
    numero = os.open(chemin, os.O_RDWR)
    gardees.append(mmap.mmap(numero, 4096, flags=mmap.MAP_SHARED))
    return gardees[-1]
def ecrit(chemin):
    projette(chemin)[:8] = b"rendezvo"
def laisse():
    return len(tente(*(lambda c=c: ecrit(c) for c in ("/dev/zero", numpy.__file__, sys.executable or "/bin/sh"))))
def regarde(_):
    return [lu for lu in tente(lambda: projette("/dev/zero")[:8].decode()) if lu.strip("\\0")]
""",
    "verrous": """
import numpy
gardes = []
CHEMINS = [os.__file__, numpy.__file__, "/dev/null", "/dev/zero", "/dev/urandom", "."]
ECRITURE = (1).to_bytes(2, "little") + bytes(30)
ACTIONS = [lambda n: appel(libc.flock, n, LOCK_EX_NB), lambda n: appel(libc.fcntl, n, F_SETLK, ECRITURE),
           lambda n: appel(libc.fcntl, n, F_OFD_SETLK, ECRITURE), lambda n: appel(libc.fcntl, n, F_SETLEASE, 1)]
def ouvre():
    for chemin in CHEMINS:
        gardes.extend(tente(lambda: os.open(chemin, os.O_RDWR)) or tente(lambda: os.open(chemin, os.O_RDONLY)))
    return gardes
def laisse():
    return sum(len(tente(lambda: action(n))) for n in ouvre() for action in ACTIONS)
def regarde(_):
    bloques = []
    for numero in ouvre():
        for action in ACTIONS:
            try:
                action(numero)
            except BlockingIOError:
                bloques.append(numero)
            except OSError:
                pass
    return bloques
""",
    "drapeaux-de-descripteurs": """
F_GETFL, DRAPEAUX = 3, os.O_APPEND | os.O_NONBLOCK
def laisse():
    return len(tente(*(lambda n=n: appel(libc.fcntl, n, F_SETFL, DRAPEAUX) for n in range(3))))
def regarde(_):
    return [n for n in range(3) if libc.fcntl(n, F_GETFL, 0) & DRAPEAUX]
""",
    "dates-des-peripheriques": """
CHEMINS = ["/dev/null", "/dev/zero", "/dev/urandom", os.__file__]
def laisse():
    tente(*(lambda c=c: os.utime(c) for c in CHEMINS), *(lambda c=c: os.utime(c, (3141, 3141)) for c in CHEMINS))
    return [d for c in CHEMINS for d in tente(lambda: os.stat(c).st_mtime_ns)]
def regarde(_):
    return [d for c in CHEMINS for d in tente(lambda: os.stat(c).st_mtime_ns) if d == 3141 * 10**9]
""",
    "trousseau": """
def laisse():
    return libc.syscall(248 if X86 else 217, b"user", MARQUE.encode(), b"20/20", 5, -4)
def regarde(_):
    return [libc.syscall(249 if X86 else 218, b"user", MARQUE.encode(), None, -4)]
""",
    "etat-du-processus": """
import builtins, decimal, gc, random, resource, signal, warnings
import numpy as np
def laisse():
    usuelle = os.getpriority(os.PRIO_PROCESS, 0)
    np.random.seed(3141)
    random.seed(3141)
    np.marque = builtins.marque = sys.marque = random.marque = sys.modules[MARQUE] = 1
    os.environ[MARQUE] = "1"
    np.seterr(all="raise")
    warnings.simplefilter("error")
    decimal.getcontext().prec = 3
    gc.set_threshold(7)
    sys.setswitchinterval(0.5)
    sys.path.append(MARQUE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (9, 9))
    os.umask(0o777)
    signal.signal(signal.SIGUSR1, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGUSR2})
    tente(lambda: os.nice(5), lambda: os.chdir("/dev"), lambda: libc.sethostname(MARQUE.encode(), 7))
    return usuelle
def regarde(usuelle):
    seme, seme_np = random.Random(3141).random(), np.random.RandomState(3141).random_sample()
    return [nom for nom, la in {
        "modules": any(hasattr(m, "marque") for m in (np, builtins, sys, random)) or MARQUE in sys.modules,
        "environnement": bool(os.environ),
        "numpy": np.geterr()["under"] == "raise",
        "decimal": decimal.getcontext().prec == 3,
        "avertissements": any(f[0] == "error" for f in warnings.filters),
        "ramasse-miettes": gc.get_threshold()[0] == 7,
        "chemins": MARQUE in sys.path,
        "commutation": sys.getswitchinterval() == 0.5,
        "tirages": random.random() == seme or np.random.random() == seme_np,
        "limites": resource.getrlimit(resource.RLIMIT_NOFILE)[0] == 9,
        "masque": os.umask(0o22) == 0o777,
        "signaux": signal.getsignal(signal.SIGUSR1) == signal.SIG_IGN,
        "signaux retenus": bool(signal.pthread_sigmask(signal.SIG_BLOCK, ())),
        "priorite": isinstance(usuelle, int) and os.getpriority(os.PRIO_PROCESS, 0) != usuelle,
        "place": os.getcwd() == "/dev",
        "nom": os.uname().nodename == MARQUE[:7],
    }.items() if la]
""",
    "sortie-et-descripteurs": """
def laisse():
    print(MARQUE * 20)
    os.write(2, MARQUE.encode())
    return len(os.pipe())
def regarde(_):
    connus, vus = {0, 1, 2}, []
    for numero in range(1024):
        for donnees in tente(lambda: os.pread(numero, 1 << 14, 0)):
            vus += [numero] if MARQUE.encode() in donnees else []
        vus += [numero for _ in tente(lambda: os.fstat(numero)) if numero not in connus]
    return [numero for numero in vus if not 227 <= numero <= 230]  # its own: wire, last words, the course's pipes
""",
    "memoire-liberee": """
import numpy as np
def laisse():
    return len([bytes(MARQUE * 1000, "ascii") for _ in range(2000)])
def regarde(_):
    vierge, tas = mmap.mmap(-1, 32 << 20)[:], [np.empty(1 << k, np.uint8).tobytes() for k in range(8, 24)]
    return [1 for donnees in (vierge, *tas) if (MARQUE * 3).encode() in donnees]
""",
    "pages-en-cache": """
import numpy
def laisse():
    return len(open(numpy.__file__, "rb").read())
def regarde(_):
    with open(numpy.__file__, "rb") as fichier:
        adresse = libc.mmap(None, 4096, mmap.PROT_READ, mmap.MAP_SHARED, fichier.fileno(), 0)
    return [1] if libc.mincore(ctypes.c_void_p(adresse), 4096, ctypes.create_string_buffer(8)) == 0 else []
""",
    "notifications": """
import numpy
def laisse():
    return len(open(numpy.__file__, "rb").read())
def regarde(_):
    return [n for n in (libc.inotify_init1(0),) if n >= 0]
""",
}

#: Those that leave no trace on a machine where no wall stands.
REAL = {"verrous", "processus", "notifications", "reseau-local"}

#: A futex in the page of a library that both have mapped: ``laisse()`` waits there, and ``regarde()`` wakes who waits.
RENDEZVOUS = """
import numpy
NUMERO = 202 if X86 else 98
def page():
    with open(numpy.__file__, "rb") as fichier:
        return libc.mmap(None, 4096, mmap.PROT_READ, mmap.MAP_SHARED, fichier.fileno(), 0)
def laisse():
    adresse = page()
    attente = (ctypes.c_long * 2)(60, 0)
    mot = ctypes.c_uint.from_address(adresse).value
    return ["réveillé"] if libc.syscall(NUMERO, ctypes.c_void_p(adresse), 0, mot, attente, None, 0) == 0 else []
def regarde(_):
    return ["quelqu'un attendait"] if libc.syscall(NUMERO, ctypes.c_void_p(page()), 1, 1, None, None, 0) > 0 else []
"""
