"""The options of what authors run: `balise new`."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]

KINDS = ("module", "page", "exercise", "choice", "numbers", "order", "replay")


def add(commands: "Commands") -> None:
    help_text = "écrit le squelette d’un module, d’une page, d’un exercice ou d’une animation, qui marche tel quel"
    _new(commands.add_parser("new", help=help_text, description=f"{help_text.capitalize()}."))


def course(parser: argparse.ArgumentParser) -> None:
    help_text = "dossier d’un cours hors de Balise, pris en place (avec ceux de BALISE_COURSES)"
    parser.add_argument("--course", type=Path, metavar="DIR", help=help_text)


def _new(parser: argparse.ArgumentParser) -> None:
    help_text = (
        "module, page, exercise (de code), choice (questionnaire), numbers (calcul), order (démonstration), replay"
    )
    parser.add_argument("kind", choices=KINDS, metavar="KIND", help=help_text)
    help_text = "le module (l19), ou le module et un nom (l19/gain ; pour une page, l19/fiches/gain)"
    parser.add_argument("name", metavar="NAME", help=help_text)
    help_text = "dossier du cours (par défaut : celui du module, ou le dossier où l’on est)"
    parser.add_argument("--course", dest="into", type=Path, metavar="DIR", help=help_text)
