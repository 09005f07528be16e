"""Thousands of NaN, which are never the same."""


def repondre(*arguments):
    return [float("nan")] * (LIMITES["items"] - 100)
