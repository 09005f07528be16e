import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 248, "aarch64": 217}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "add_key est passé"
