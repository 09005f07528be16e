def composer(a, b):
    return a[3] + b


def inverse(a):
    return a / zero


def relatif(a, b):
    return composer(inverse(a), b)
