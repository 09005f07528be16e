import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 323, "aarch64": 282}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "userfaultfd est passé"
