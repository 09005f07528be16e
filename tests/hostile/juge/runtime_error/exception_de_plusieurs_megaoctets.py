"""An exception whose text is megabytes long."""


def repondre(*arguments):
    raise ValueError("x" * 10_000_000)
