"""A triangle: no array can be made of it."""


def repondre(*arguments):
    return [[0.5] * k for k in range(130)]
