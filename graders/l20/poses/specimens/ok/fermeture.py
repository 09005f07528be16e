"""A function that makes functions: a pose is the map of the plane that it stands for, read at two points."""


def repere(p):
    c, s = np.cos(p[2]), np.sin(p[2])

    def vers_le_monde(u, v):
        return p[0] + c * u - s * v, p[1] + s * u + c * v

    def vers_le_robot(u, v):
        du, dv = u - p[0], v - p[1]
        return c * du + s * dv, -s * du + c * dv

    return vers_le_monde, vers_le_robot


def pose(origine, pointe):
    return np.array([origine[0], origine[1], np.arctan2(pointe[1] - origine[1], pointe[0] - origine[0])])


def composer(a, b):
    de_a, _ = repere(a)
    de_b, _ = repere(b)
    return pose(de_a(*de_b(0, 0)), de_a(*de_b(1, 0)))


def inverse(a):
    _, vers = repere(a)
    return pose(vers(0, 0), vers(1, 0))


def relatif(a, b):
    de_b, _ = repere(b)
    _, vers = repere(a)
    return pose(vers(*de_b(0, 0)), vers(*de_b(1, 0)))
