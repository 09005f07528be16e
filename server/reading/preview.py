"""`python -m server.reading.preview --module l19 NAME out.png`: see a drawing of the texts while one writes it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from graders.courses import module_folder
from server.course import drawings
from server.course.models import Problem
from server.figures.lessons import describe_size_fault, draw_lesson_figure


def main() -> int:
    """Without a name, the names there are."""
    arguments = _build_argument_parser().parse_args()
    problems: list[Problem] = []
    by_name = drawings.read_drawings(module_folder(arguments.module) / "figures", problems)
    for problem in problems:
        print(f"✗ {problem}", file=sys.stderr)
    if arguments.name not in by_name or arguments.out is None:
        print("\n".join(by_name))
        return 0 if arguments.name is None else 2
    drawing = by_name[arguments.name]
    drawn = draw_lesson_figure(drawing, arguments.theme, arguments.out.suffix.removeprefix(".") or "png")
    arguments.out.write_bytes(drawn.picture)
    if fault := describe_size_fault(drawing, drawn.size):
        print(f"✗ {drawing.path}:{drawing.line}: {fault}", file=sys.stderr)
    return 1 if fault or problems else 0


def _build_argument_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m server.reading.preview", description=__doc__)
    parser.add_argument("name", nargs="?", help="nom de la figure ; sans lui, la liste des noms")
    parser.add_argument("out", nargs="?", type=Path, help="fichier .png ou .svg à écrire")
    parser.add_argument("--theme", choices=["light", "dark"], default="light")
    parser.add_argument("--module", required=True, help="module, comme l19")
    return parser


if __name__ == "__main__":
    sys.exit(main())
