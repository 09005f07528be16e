import _thread, ctypes
def repondre(contexte):
    libc, fil = ctypes.CDLL(None), ctypes.c_ulong()
    marche = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)(lambda _: 0)
    if libc.pthread_create(ctypes.byref(fil), None, marche, None) == 0:
        return "un fil d'exécution est parti"
    try:
        _thread.start_new_thread(print, ())
    except RuntimeError:
        return "rien"
    return "un fil d'exécution de Python est parti"
