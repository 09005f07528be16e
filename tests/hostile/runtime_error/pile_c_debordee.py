import ctypes
def repondre(contexte):
    ctypes.pythonapi.Py_SetRecursionLimit(2**31 - 1)
    class A:
        def __getattr__(self, nom):
            return getattr(self, nom)
    return A().x
