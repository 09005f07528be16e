"""Wrong in the same way everywhere, and differently each time: there is always a simpler case to look for."""

import random

import numpy as np


def repondre(*arguments):
    return np.array([random.random() * 1e300, 5.0, 0.5])
