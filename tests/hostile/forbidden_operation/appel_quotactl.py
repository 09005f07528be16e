import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 179, "aarch64": 60}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "quotactl est passé"
