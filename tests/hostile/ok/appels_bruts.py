import ctypes, platform
NUMEROS = {
    "x86_64": {"fork": 57, "clone3": 435, "clone": 56, "execve": 59, "kill": 62, "socket": 41, "shmget": 29, "msgget": 68,
               "memfd_create": 319, "pidfd_open": 434, "landlock_restrict_self": 446, "seccomp": 317, "prctl": 157, "sched_setaffinity": 203},
    "aarch64": {"clone": 220, "clone3": 435, "execve": 221, "kill": 129, "socket": 198, "shmget": 194, "msgget": 186,
                "memfd_create": 279, "pidfd_open": 434, "landlock_restrict_self": 446, "seccomp": 277, "prctl": 167},
}
def repondre(contexte):
    libc = ctypes.CDLL(None, use_errno=True)
    reussis = [nom for nom, numero in NUMEROS.get(platform.machine(), {}).items() if libc.syscall(numero, 0, 0, 0, 0, 0, 0) != -1]
    return str(reussis) if reussis else "rien"
