"""Booleans by thousands, in lists of lists."""


def repondre(*arguments):
    return [[True, False] * 40] * 110
