import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 304, "aarch64": 265}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "open_by_handle_at est passé"
