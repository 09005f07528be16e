import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 311, "aarch64": 271}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "process_vm_writev est passé"
