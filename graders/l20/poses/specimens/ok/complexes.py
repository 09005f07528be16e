"""Complex numbers; the half turn is written -pi."""
import cmath
from l20 import np as numpy


def composer(a, b):
    z = complex(a[0], a[1]) + cmath.exp(1j * a[2]) * complex(b[0], b[1])
    return numpy.array([z.real, z.imag, cmath.phase(cmath.exp(1j * (a[2] + b[2])))])


def inverse(a):
    z = -complex(a[0], a[1]) * cmath.exp(-1j * a[2])
    return numpy.array([z.real, z.imag, -a[2]])


def relatif(a, b):
    z = (complex(b[0], b[1]) - complex(a[0], a[1])) * cmath.exp(-1j * a[2])
    return numpy.array([[z.real, z.imag, (b[2] - a[2] + numpy.pi) % (2 * numpy.pi) - numpy.pi]]).ravel()
