import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 250, "aarch64": 219}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "keyctl est passé"
