import ctypes
def repondre(contexte):
    code = ctypes.CFUNCTYPE(None)(0xDEAD0000)
    code()
