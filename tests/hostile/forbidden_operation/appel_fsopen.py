import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 430, "aarch64": 430}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "fsopen est passé"
