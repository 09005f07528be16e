"""Rows of bytes beside one of huge integers: millions of Python objects once they are one array."""

import numpy as np


def repondre(*arguments):
    n = LIMITES["items"] - 500
    return [np.ones(n, dtype=np.uint8)] * 400 + [[2**70] * n]
