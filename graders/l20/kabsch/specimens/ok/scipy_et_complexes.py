"""SciPy's align_vectors in space, complex numbers in the plane, a named pair as the result."""
from collections import namedtuple

import numpy
from scipy.spatial.transform import Rotation

Rigide = namedtuple("Rigide", "R t")


def kabsch(P, Q):
    a, b = P - P.mean(0), Q - Q.mean(0)
    if P.shape[1] == 3:
        R = Rotation.align_vectors(b, a)[0].as_matrix()
    else:
        z = numpy.sum((a[:, 0] - 1j * a[:, 1]) * (b[:, 0] + 1j * b[:, 1]))
        z = z / abs(z) if abs(z) > 0 else 1
        R = numpy.array([[z.real, -z.imag], [z.imag, z.real]])
    print("angle", R)
    return tuple(Rigide(R, Q.mean(0) - R @ P.mean(0)))
