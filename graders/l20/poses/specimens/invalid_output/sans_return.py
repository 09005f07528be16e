def composer(a, b):
    print(a, b)


def inverse(a):
    print(a)


def relatif(a, b):
    return "x"
