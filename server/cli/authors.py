"""The options of what authors run: `balise new`, `balise schema`, `balise preview`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from server.cli.options import parse_bounded_integer


class SubcommandsAction(Protocol):
    """What `ArgumentParser.add_subparsers` returns; its class has no public name."""

    @property
    def add_parser(self) -> Callable[..., argparse.ArgumentParser]: ...


#: Kinds of skeletons: each is a folder of `server/authoring/skeletons`.
KINDS = ("module", "page", "exercise", "declared", "choice", "numbers", "order", "replay")
#: What copies a module instead, beside those that classes keep.
EDITION = "edition"


def add_author_commands(commands: SubcommandsAction) -> None:
    help_text = "écrit le squelette d’un module, d’une page, d’un exercice ou d’une animation, qui marche tel quel"
    _add_new_options(commands.add_parser("new", help=help_text, description=f"{help_text.capitalize()}."))
    help_text = "écrit les schémas des fichiers TOML d’un cours, pour que l’éditeur en complète les clés"
    _add_schema_options(commands.add_parser("schema", help=help_text, description=f"{help_text.capitalize()}."))
    help_text = "montre ce que des classes ratent de la même façon, et qu’aucune erreur connue ne nomme"
    _add_study_options(commands.add_parser("study", help=help_text, description=f"{help_text.capitalize()}."))
    help_text = "montre un cours pendant qu’on l’écrit, sur cette machine seulement"
    _add_preview_options(commands.add_parser("preview", help=help_text, description=f"{help_text.capitalize()}."))


def _add_schema_options(parser: argparse.ArgumentParser) -> None:
    help_text = "dossier du cours (par défaut : celui où l’on est)"
    parser.add_argument("--course", dest="into", type=Path, default=Path(), metavar="DIR", help=help_text)


def _add_study_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("exercise", metavar="EXERCISE", help="exercice de code, comme l20/poses")
    help_text = "fait de ce groupe une erreur à nommer, dans le dossier du correcteur"
    parser.add_argument("--write", metavar="GROUP", help=help_text)
    help_text = "combien de groupes, du plus fréquent au plus rare (par défaut : %(default)s)"
    parser.add_argument("--most", type=_parse_max_count, default=10, metavar="N", help=help_text)
    parser.add_argument("--data", type=Path, metavar="DIR", help="dossier des données du service")
    add_course_option(parser)


def _parse_max_count(text: str) -> int:
    return max(1, parse_bounded_integer(text, 1000, "le nombre de groupes"))


def add_course_option(parser: argparse.ArgumentParser) -> None:
    help_text = "dossier d’un cours hors de Balise, pris en place (avec ceux de BALISE_COURSES)"
    parser.add_argument("--course", type=Path, metavar="DIR", help=help_text)


def _add_preview_options(parser: argparse.ArgumentParser) -> None:
    help_text = "module, comme l19, ou dossier d’un cours (par défaut : le premier de BALISE_COURSES, ou celui d’ici)"
    parser.add_argument("what", nargs="?", metavar="MODULE|DIR", help=help_text)
    help_text = "port, 0 pour un port libre (par défaut : %(default)s)"
    parser.add_argument("--port", type=_parse_port, default=8010, help=help_text)


def _parse_port(text: str) -> int:
    return parse_bounded_integer(text, 65535, "le port")


def _add_new_options(parser: argparse.ArgumentParser) -> None:
    help_text = (
        "module, page, exercise (de code), choice (questionnaire), numbers (calcul), order (démonstration), replay, "
        "ou edition : un module recopié, que l’on changera sans toucher à celui des classes"
    )
    parser.add_argument("kind", choices=(*KINDS, EDITION), metavar="KIND", help=help_text)
    help_text = "le module (l19), ou le module et un nom (l19/gain ; pour une page, l19/fiches/gain)"
    parser.add_argument("name", metavar="NAME", help=help_text)
    help_text = (
        "avec declared : fichier d’où importer (questions CodeRunner en XML de Moodle, données d’Exercism en JSON, "
        "notebook de nbgrader)"
    )
    parser.add_argument("--from", dest="source", type=Path, metavar="FILE", help=help_text)
    help_text = "dossier du cours (par défaut : celui du module, ou le dossier où l’on est)"
    parser.add_argument("--course", dest="into", type=Path, metavar="DIR", help=help_text)
