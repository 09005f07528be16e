"""Answers zeros, and makes of its arguments what an answer may weigh."""

import numpy as np


def repondre(*arguments):
    for argument in arguments:
        if isinstance(argument, np.ndarray):
            argument.resize(LIMITES["frame_bytes"] // 24, refcheck=False)
    return np.zeros(3)
