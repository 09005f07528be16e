"""`balise grade EXERCISE FILE [--json] [--seed N]`, and `--questions` for what an exercise without code asks.

What starts a sandbox is all that is imported here: its template comes up while `graded.py`, which grades, is loaded.
"""

import logging
import sys
from argparse import Namespace

from server.cli import CommandError, imports_without_garbage_collection, wall_cache
from server.cli.files import ANSWERS, read_source
from server.cli.sandboxes import sandbox_starting_early, start_probing_walls


def run(arguments: Namespace) -> int:
    logging.basicConfig(level=logging.WARNING, stream=sys.stderr)
    if arguments.questions:
        from server.cli.grade_run import print_questions

        return print_questions(arguments)
    if arguments.file is None:
        raise CommandError("il manque le fichier à corriger.")
    source = read_source(arguments.file)
    if arguments.file.endswith(ANSWERS):
        from server.cli.grade_run import grade_answers

        status = grade_answers(arguments, source)
        if status is not None:
            return status
    with sandbox_starting_early(arguments.exercise, source) as sandbox:
        probing = None if wall_cache.are_walls_recently_verified() else start_probing_walls(slow=False)
        with imports_without_garbage_collection(arguments):
            from server.cli.grade_run import grade_code
        return grade_code(arguments, source, sandbox, probing)
