import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 167, "aarch64": 224}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "swapon est passé"
