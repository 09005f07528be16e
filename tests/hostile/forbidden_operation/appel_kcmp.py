import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 312, "aarch64": 272}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "kcmp est passé"
