import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 429, "aarch64": 429}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "move_mount est passé"
