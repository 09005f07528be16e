import ctypes, platform
def repondre(contexte):
    if platform.machine() != "x86_64":
        raise PermissionError
    ctypes.CDLL(None).syscall(0x40000000 | 39)
    return "x32 est passé"
