from functools import reduce

gain = lambda v, r: v / (r + v)
corrige = lambda c, o: (c[0] - gain(c[1], o[1]) * (c[0] - o[0]), c[1] - gain(c[1], o[1]) * c[1])
fusionner = lambda mesures, variances: reduce(corrige, zip(mesures, variances))
enchainer = lambda m, v, mesures, variances: [
    reduce(corrige, zip(mesures[: k + 1], variances[: k + 1]), (m, v)) for k in range(len(mesures))
]
