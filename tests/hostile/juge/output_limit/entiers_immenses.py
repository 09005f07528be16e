"""Integers as long as the wire takes them, which no float holds."""


def repondre(*arguments):
    return [2**4000 + k for k in range(3000)]
