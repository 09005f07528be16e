def relatif(a, b):
    return b - a
