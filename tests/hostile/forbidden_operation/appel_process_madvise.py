import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 440, "aarch64": 440}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "process_madvise est passé"
