# left: lost
import sys
def suivre():
    def la_sienne(cadre, evenement, valeur):
        return la_sienne
    x = 1
    sys.settrace(la_sienne)
    y = 2
    sys._getframe().f_trace = la_sienne
    z = 3
    return "rien"
