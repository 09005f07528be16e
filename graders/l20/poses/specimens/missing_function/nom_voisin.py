def composer(a, b):
    return a


def inverser(a):
    return a


def relatif(a, b):
    return b
