"""An array of a million where three numbers are asked."""

import numpy as np


def repondre(*arguments):
    return np.zeros(1_000_000)
