import ctypes, platform
def repondre(contexte):
    if platform.machine() != "x86_64":
        raise PermissionError
    ctypes.CDLL(None).syscall(154, 0, 0, 0)
    return "modify_ldt est passé"
