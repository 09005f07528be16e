"""A class with operators: a * b composes, ~a inverts."""


class Pose:
    def __init__(self, x, y, theta):
        self.x, self.y, self.theta = x, y, theta

    def __mul__(self, autre):
        c, s = np.cos(self.theta), np.sin(self.theta)
        return Pose(self.x + c * autre.x - s * autre.y, self.y + s * autre.x + c * autre.y, self.theta + autre.theta)

    def __invert__(self):
        c, s = np.cos(self.theta), np.sin(self.theta)
        return Pose(-c * self.x - s * self.y, s * self.x - c * self.y, -self.theta)

    def __array__(self, dtype=None, copy=None):
        return np.array([self.x, self.y, np.arctan2(np.sin(self.theta), np.cos(self.theta))])


def composer(a, b):
    return np.array(Pose(*a) * Pose(*b))


def inverse(a):
    return np.array(~Pose(*a))


def relatif(a, b):
    return np.array(~Pose(*a) * Pose(*b))
