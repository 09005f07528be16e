import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 175, "aarch64": 105}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "init_module est passé"
