import ctypes, platform
def repondre(contexte):
    if platform.machine() != "x86_64":
        raise PermissionError
    ctypes.CDLL(None).syscall(173, 0, 1, 1)
    return "ioperm est passé"
