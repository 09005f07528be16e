import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 249, "aarch64": 218}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "request_key est passé"
