from scipy.spatial.transform import Rotation


def de(p):
    return Rotation.from_euler("z", p[2]), np.array([p[0], p[1], 0.0])


def vers(rotation, t):
    return np.array([t[0], t[1], rotation.as_euler("xyz")[2]])


def composer(a, b):
    (Ra, ta), (Rb, tb) = de(a), de(b)
    return vers(Ra * Rb, ta + Ra.apply(tb))


def inverse(a):
    R, t = de(a)
    return vers(R.inv(), -R.inv().apply(t))


def relatif(a, b):
    (Ra, ta), (Rb, tb) = de(a), de(b)
    return vers(Ra.inv() * Rb, Ra.inv().apply(tb - ta))
