def distance2(z, amers, S):
    return np.zeros((len(z), len(amers)))


def association(z, amers, S, niveau=0.99):
    return [-1] * len(z)


def nouveau(z, amers, S, niveau=0.99):
    return []


def jcbb(z, amers, C, R, niveau=0.99):
    return [-1] * len(z)
