"""Complex numbers, where real ones are asked."""

import numpy as np


def repondre(*arguments):
    return np.full((20, 20), 1 + 1j)
