"""`balise grade EXERCISE FILE [--json] [--seed N]`."""

import json
import logging
import secrets
import sys
from argparse import Namespace

from server.cli import report
from server.cli.files import read_source
from server.cli.local import find, load_catalogue, local_grader, start_probing
from server.submissions.draws import SEED_BITS


def run(arguments: Namespace) -> int:
    logging.basicConfig(level=logging.WARNING, stream=sys.stderr)
    source, probing = read_source(arguments.file), start_probing(slow=False)
    catalogue = load_catalogue()
    exercise = find(catalogue, arguments.exercise)
    seed = secrets.randbits(SEED_BITS) if arguments.seed is None else arguments.seed
    with local_grader(catalogue, probing) as grader:
        verdict = grader.grade(exercise.id, source, seed).verdict.to_json()
    print(json.dumps(verdict, ensure_ascii=False, allow_nan=False) if arguments.json else report.render(verdict))
    return report.exit_status(verdict)
