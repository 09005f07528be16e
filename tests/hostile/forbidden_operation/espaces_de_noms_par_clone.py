import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 56, "aarch64": 220}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0x10000000 | 17, 0, 0, 0, 0)
    return "clone est passé"
