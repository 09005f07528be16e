import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 428, "aarch64": 428}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "open_tree est passé"
