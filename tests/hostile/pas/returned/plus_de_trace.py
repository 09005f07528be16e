# left: lost
import sys
def suivre():
    x = 1
    sys.settrace(None)
    y = 2
    return "rien"
