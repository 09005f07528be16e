import os
def suivre():
    x = 1
    os._exit(3)
