import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 425, "aarch64": 425}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "io_uring_setup est passé"
