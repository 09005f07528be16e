def relatif(a, b):
    return composer(b, inverse(a))
