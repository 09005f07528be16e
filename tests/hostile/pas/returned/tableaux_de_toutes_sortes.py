import numpy as np
class Piege:
    __repr__ = __str__ = __eq__ = __float__ = __bool__ = lambda *_: print("touché")
def suivre():
    tous = [np.zeros((1,) * 32), np.array(5), np.zeros(0), np.array(["a", "b" * 900]), np.array([b"x"])]
    tous += [np.zeros(3, dtype=t) for t in ("f2", "f4", "f8", "g", "G", "c8", "c16", "?", "u1", ">i4", "M8[s]", "V5", "i4,f8")]
    tous += [np.array([Piege(), None, 10**5000, "x" * 500, [1]], dtype=object), np.ma.array([1, 2], mask=[0, 1])]
    tous += [np.array([np.nan, np.inf, -0.0]), np.array([complex("nan+1j")]), np.zeros((3, 4)).T, np.zeros(9)[::-2]]
    for un in tous:
        deux = un
    scalaires = [np.float64(1), np.float32(0.1), np.longdouble(1), np.int8(3), np.bool_(True), np.str_("a"), np.void(b"ab")]
    for trois in scalaires:
        quatre = trois
    return "rien"
