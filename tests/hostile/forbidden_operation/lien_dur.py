import numpy, os
def repondre(contexte):
    os.link(numpy.__file__, "numpy.py")
