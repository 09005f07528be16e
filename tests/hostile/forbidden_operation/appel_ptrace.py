import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 101, "aarch64": 117}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "ptrace est passé"
