import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 165, "aarch64": 40}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "mount est passé"
