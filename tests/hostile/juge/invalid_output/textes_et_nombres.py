"""Texts among numbers: numpy would make every item as long as the longest."""


def repondre(*arguments):
    return ["x" * 20_000] + [0.5] * 900
