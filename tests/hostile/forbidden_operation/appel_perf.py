import ctypes, platform
def repondre(contexte):
    numero = {"x86_64": 298, "aarch64": 241}[platform.machine()]
    ctypes.CDLL(None).syscall(numero, 0, 0, 0, 0, 0, 0)
    return "perf_event_open est passé"
