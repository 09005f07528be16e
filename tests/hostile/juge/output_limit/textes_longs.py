"""A text of megabytes, where numbers are asked."""


def repondre(*arguments):
    return "é" * (LIMITES["frame_bytes"] // 2 - 100)
