def relatif(a, b):
    return composer(inverse(b), a)
