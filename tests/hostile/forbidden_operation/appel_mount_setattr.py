import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 442, "aarch64": 442}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "mount_setattr est passé"
