import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 321, "aarch64": 280}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "bpf est passé"
