import ctypes
def suivre():
    x = 1
    ctypes.string_at(8)
