# left: lost
import sys
def leve(cadre, evenement, valeur):
    raise RuntimeError
def g():
    return 1
def suivre():
    sys._getframe().f_trace_opcodes = True
    sys._getframe().f_trace = None
    try:
        sys.settrace(leve)
        g()
    except RuntimeError:
        pass
    return "rien"
