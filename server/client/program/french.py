"""argparse in French: its own words would be in English, as a file cannot carry a catalogue of gettext."""

from __future__ import annotations

import argparse
import sys
from typing import Any, NoReturn

from .report import CANNOT


class FrenchHelpFormatter(argparse.HelpFormatter):
    """The heading of a command's usage."""

    def add_usage(self, usage: Any, actions: Any, groups: Any, prefix: str | None = None) -> None:
        super().add_usage(usage, actions, groups, "utilisation : " if prefix is None else prefix)


class FrenchParser(argparse.ArgumentParser):
    """A parser of which each argument is added to a group with a French title."""

    def __init__(self, **options: Any) -> None:
        super().__init__(add_help=False, formatter_class=FrenchHelpFormatter, **options)
        self.arguments = self.add_argument_group("arguments")
        self.arguments.add_argument("-h", "--help", action="help", help="affiche cette aide")

    def error(self, message: str) -> NoReturn:
        self.print_usage(sys.stderr)
        self.exit(CANNOT, "balise : commande incomplète ou inconnue ; « -h » affiche l’aide.\n")
