# left: depth
def suivre(n=0):
    return suivre(n + 1)
