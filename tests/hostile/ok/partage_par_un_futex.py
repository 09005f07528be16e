import ctypes, mmap, numpy, platform
def repondre(contexte):
    numero = {"x86_64": 202, "aarch64": 98}[platform.machine()]
    libc = ctypes.CDLL(None, use_errno=True)
    libc.mmap.restype = ctypes.c_void_p
    with open(numpy.__file__, "rb") as fichier:
        adresse = libc.mmap(None, 4096, mmap.PROT_READ, mmap.MAP_SHARED, fichier.fileno(), 0)
        reveilles = libc.syscall(numero, ctypes.c_void_p(adresse), 1, 1, None, None, 0)
    return "rien" if reveilles == -1 else "un futex d'un fichier partagé répond"
