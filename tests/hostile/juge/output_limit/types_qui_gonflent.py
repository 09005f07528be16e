"""Rows of bytes beside one of complex numbers: sixteen times larger once they are one array."""

import numpy as np


def repondre(*arguments):
    n = LIMITES["frame_bytes"] // 120
    return [np.ones(n, dtype=np.uint8)] * 100 + [np.ones(n, dtype=complex) * 1j]
