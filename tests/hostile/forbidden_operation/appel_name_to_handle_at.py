import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 303, "aarch64": 264}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "name_to_handle_at est passé"
