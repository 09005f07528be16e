"""argparse's own words in French, by gettext, through which it looks for all of them."""

import gettext
import os
from pathlib import Path

CATALOGUE = "argparse"
LOCALE = Path(__file__).parent / "locale"


def translate_argparse() -> None:
    """Call before making a parser. Balise speaks French wherever it runs, so that the machine's language is replaced.

    A message that the catalogue does not hold stays as it is.
    """
    os.environ["LANGUAGE"] = "fr"
    gettext.bindtextdomain(CATALOGUE, str(LOCALE))
    gettext.textdomain(CATALOGUE)
