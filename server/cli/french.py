"""argparse's own words in French: it looks each of them up through the names `_` and `ngettext` of its module."""

import argparse

FRENCH = {
    "usage: ": "utilisation\u00a0: ",
    "positional arguments": "arguments",
    "options": "options",
    "show this help message and exit": "affiche cette aide",
    "%(prog)s: error: %(message)s\n": "%(prog)s\u00a0: %(message)s\n",
    "argument %(argument_name)s: %(message)s": "%(argument_name)s\u00a0: %(message)s",
    "the following arguments are required: %s": "il manque %s",
    "unrecognized arguments: %s": "argument inconnu\u00a0: %s",
    "invalid choice: %(value)r (choose from %(choices)s)": (
        "«\u202f%(value)s\u202f» n’existe pas. Au choix\u00a0: %(choices)s"
    ),
    "expected one argument": "il manque sa valeur",
    "ignored explicit argument %r": "ne prend pas de valeur (%s)",
    "ambiguous option: %(option)s could match %(matches)s": "«\u202f%(option)s\u202f» est ambigu\u00a0: %(matches)s",
}


def speak_french() -> None:
    """Call before making a parser. A message that has no French here stays as it is."""
    vars(argparse)["_"] = lambda text: FRENCH.get(text, text)
