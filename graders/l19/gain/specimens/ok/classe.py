class Avis:
    def __init__(self, moyenne, variance):
        self.moyenne, self.variance = moyenne, variance

    def entend(self, autre):
        total = self.variance + autre.variance
        moyenne = (autre.variance * self.moyenne + self.variance * autre.moyenne) / total
        return Avis(moyenne, self.variance * autre.variance / total)

    @property
    def paire(self):
        return self.moyenne, self.variance


def gain(v, r):
    return Avis(0.0, v).entend(Avis(1.0, r)).moyenne


def fusionner(mesures, variances):
    premier, *autres = map(Avis, mesures, variances)
    for autre in autres:
        premier = premier.entend(autre)
    return premier.paire


def enchainer(m, v, mesures, variances):
    avis, suite = Avis(m, v), []
    for autre in map(Avis, mesures, variances):
        avis = avis.entend(autre)
        suite.append(avis.paire)
    return suite
