"""A result made first and filled in; arguments copied as lists; a 0-d array for each entry."""
import numpy
DEUX_PI = 2 * numpy.pi


def angle(t):
    n = round(t / DEUX_PI)
    return t - n * DEUX_PI


def composer(a, b):
    a, b = list(a), list(b)
    sortie = numpy.empty(3)
    sortie[0] = a[0] + b[0] * numpy.cos(a[2]) + b[1] * numpy.cos(a[2] + numpy.pi / 2)
    sortie[1] = a[1] + b[0] * numpy.sin(a[2]) + b[1] * numpy.sin(a[2] + numpy.pi / 2)
    sortie[2] = angle(a[2] + b[2])
    return sortie


def inverse(a):
    a = list(a)
    return [numpy.array(-a[0] * numpy.cos(a[2]) - a[1] * numpy.sin(a[2])),
            numpy.array(a[0] * numpy.sin(a[2]) - a[1] * numpy.cos(a[2])),
            numpy.array(angle(-a[2]))]


def relatif(a, b):
    sortie = numpy.zeros_like(b)
    sortie += composer(inverse(a), b)
    return sortie
