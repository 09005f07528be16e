"""Thousands of small arrays, that misconceptions would be compared with one by one."""

import numpy as np


def repondre(*arguments):
    return [np.arange(3.0), np.zeros(2)] * (LIMITES["items"] // 2 - 100)
