"""Thousands of arrays of nothing."""

import numpy as np


def repondre(*arguments):
    return [np.zeros((0, 2**31 - 1))] * (LIMITES["items"] - 100)
