"""Prints what takes six times its place as JSON, beside a wrong answer."""

import numpy as np


def repondre(*arguments):
    print("\x01" * LIMITES["stdout_bytes"])
    return np.zeros(3) + 7.0
