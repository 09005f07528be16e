def inverse(a):
    return -a
