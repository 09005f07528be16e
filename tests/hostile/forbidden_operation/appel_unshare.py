import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 272, "aarch64": 97}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "unshare est passé"
