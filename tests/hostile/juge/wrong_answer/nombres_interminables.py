"""Numbers with all their digits and exponents, in the right shape."""

import numpy as np


def repondre(*arguments):
    return [-1.2345678901234567e-300, np.float64(1.7976931348623157e308), 10**400 // 7]
