import module_inconnu


def composer(a, b):
    return a
