import numpy


def predire(*arguments):
    etat, entree = numpy.reshape(arguments, (2, 2))
    return numpy.add(etat, entree).tolist()


def corriger(*arguments):
    etat, mesure = numpy.array(arguments, dtype=float).reshape(2, 2)
    (m, v), (z, r) = etat, mesure
    with numpy.errstate(all="raise"):
        K = numpy.divide(v, numpy.add(v, r))
    return numpy.stack([numpy.interp(K, [0.0, 1.0], [m, z]), numpy.multiply(1 - K, v)])
