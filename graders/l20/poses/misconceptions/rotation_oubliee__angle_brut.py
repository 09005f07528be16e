def composer(a, b):
    return a + b
