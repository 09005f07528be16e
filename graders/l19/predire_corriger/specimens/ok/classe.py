class Gaussienne:
    """A belief that two operators change: + for a move, * for another opinion."""

    def __init__(self, moyenne, variance):
        self.moyenne, self.variance = moyenne, variance

    def __add__(self, autre):
        return Gaussienne(self.moyenne + autre.moyenne, self.variance + autre.variance)

    def __mul__(self, autre):
        gain = self.variance / (self.variance + autre.variance)
        return Gaussienne(self.moyenne + gain * (autre.moyenne - self.moyenne), self.variance - gain * self.variance)

    def paire(self):
        return self.moyenne, self.variance


def predire(m, v, u, q):
    return (Gaussienne(m, v) + Gaussienne(u, q)).paire()


def corriger(m, v, z, r):
    return (Gaussienne(m, v) * Gaussienne(z, r)).paire()
