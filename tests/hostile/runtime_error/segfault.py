import ctypes
def repondre(contexte):
    ctypes.string_at(0)
