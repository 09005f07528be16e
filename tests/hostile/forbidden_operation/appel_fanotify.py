import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 300, "aarch64": 262}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "fanotify_init est passé"
