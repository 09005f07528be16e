"""Walks through all of its own process and all the files that it sees, and hands everything over.

The test of what a child knows reads it: no needle is in this file. Comments here are in the language of the corpus.
"""

import ctypes
import gc
import os
import sys
import types

import numpy as np

MORCEAU, PAGE, BLOC = 1 << 16, 1 << 12, 1 << 20
ATTRIBUTS = ("co_consts", "co_names", "co_varnames", "co_filename", "co_name", "co_linetable", "co_freevars")


def objets():
    """Tout objet que l'on atteint, par le ramasse-miettes, les modules, les cadres, les fonctions et leurs codes."""
    gc.unfreeze()  # le gabarit a mis les siens à l'écart
    attend = [*gc.get_objects(), sys.modules, sys._current_frames(), sys.getrefcount, *gc.garbage]
    atteints = {}
    while attend:
        objet = attend.pop()
        if id(objet) in atteints:
            continue
        atteints[id(objet)] = objet
        if type(objet) is types.CodeType:
            attend += [getattr(objet, nom) for nom in ATTRIBUTS]
        elif type(objet) is types.FrameType:
            attend += [objet.f_locals, objet.f_globals, objet.f_builtins, objet.f_code]
        else:
            attend += gc.get_referents(objet)
    return atteints


def textes(atteints):
    """Les chaînes, les octets et les tableaux d'octets, séparés par des zéros."""
    trouves = set()
    for objet in atteints.values():
        if type(objet) is str:
            trouves.add(objet.encode("utf-8", "replace"))
        elif type(objet) in (bytes, bytearray):
            trouves.add(bytes(objet))
        elif isinstance(objet, np.ndarray) and objet.dtype.kind in "uiSU":
            trouves.add(objet.tobytes())
    return b"\0".join(trouves)


def codes(atteints):
    """Les instructions de chaque code, puis les noms dont elles parlent ; la longueur du tout d'abord."""
    trouves = set()
    for objet in atteints.values():
        if type(objet) is types.CodeType:
            noms = " ".join(objet.co_names + objet.co_varnames).encode("utf-8", "replace")
            trouves.add(objet.co_code + noms)
    return b"".join(len(code).to_bytes(4, "little") + code for code in trouves)


def provenances(atteints):
    """D'où vient chaque code, et son nom."""
    codes = (objet for objet in atteints.values() if type(objet) is types.CodeType)
    return "\0".join({f"{code.co_filename}:{code.co_qualname}" for code in codes}).encode("utf-8", "replace")


def memoire(atteints):
    """Les octets des blocs où vivent des objets, ce qui y a été rendu compris : ce qui ne se lit pas est passé."""
    libc = ctypes.CDLL(None)
    libc.write.argtypes = (ctypes.c_int, ctypes.c_void_p, ctypes.c_size_t)
    sortie, entree = os.pipe()
    lus = bytearray()
    for bloc in sorted({adresse // BLOC for adresse in atteints}):
        adresse, fin = bloc * BLOC, (bloc + 1) * BLOC
        while adresse < fin:
            passes = libc.write(entree, adresse, min(MORCEAU, fin - adresse))
            if passes > 0:
                lus += os.read(sortie, passes)
            adresse += passes if passes > 0 else PAGE
    os.close(sortie)
    os.close(entree)
    return lus


def fichiers():
    """Les chemins de tout ce qui se voit, depuis la racine et depuis ce que Python connaît."""
    vus = set()
    modules = [os.path.dirname(getattr(module, "__file__", None) or "/") for module in list(sys.modules.values())]
    for racine in {"/", os.getcwd(), *sys.path, *modules}:
        for dossier, _, noms in os.walk(racine):
            vus |= {os.path.join(dossier, nom) for nom in noms}
    return "\0".join(sorted(vus)).encode("utf-8", "replace")


def repondre():
    atteints = objets()
    trouves = (textes(atteints), codes(atteints), memoire(atteints), provenances(atteints), fichiers())
    return tuple(np.frombuffer(morceau, np.uint8) for morceau in trouves)
