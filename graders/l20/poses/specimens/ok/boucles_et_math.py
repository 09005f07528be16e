"""Only the math module and a while loop that brings the angle back."""
from math import cos, sin, pi


def ramener(t):
    while t > pi:
        t -= 2 * pi
    while t <= -pi:
        t += 2 * pi
    return t


def composer(a, b):
    x1, y1, t1 = a
    x2, y2, t2 = b
    return [x1 + cos(t1) * x2 - sin(t1) * y2, y1 + sin(t1) * x2 + cos(t1) * y2, ramener(t1 + t2)]


def inverse(a):
    x, y, t = a
    return [-(cos(t) * x + sin(t) * y), -(-sin(t) * x + cos(t) * y), ramener(-t)]


def relatif(a, b):
    dx, dy = b[0] - a[0], b[1] - a[1]
    return [cos(a[2]) * dx + sin(a[2]) * dy, cos(a[2]) * dy - sin(a[2]) * dx, ramener(b[2] - a[2])]
