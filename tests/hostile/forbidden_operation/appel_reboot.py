import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 169, "aarch64": 142}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "reboot est passé"
