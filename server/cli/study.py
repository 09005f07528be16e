"""`balise study EXERCISE`: what is failed alike in the database, and named by nothing yet."""

import os
from argparse import Namespace
from collections.abc import Sequence

from server.authoring import study
from server.authoring.study import UnexplainedGroup
from server.base.errors import Invalid
from server.cli import CommandError
from server.cli.configuration import read_settings
from server.cli.database import open_database
from server.cli.local import find_exercise, load_unrendered_course, local_grader
from server.cli.sandboxes import start_probing_walls
from server.course import Exercise
from server.grading.sandbox_grader import SandboxGrader


def run(arguments: Namespace) -> int:
    probing = start_probing_walls(slow=False)
    course = load_unrendered_course()
    exercise = find_exercise(course, arguments.exercise)
    found = _find_unexplained_groups(arguments, exercise)
    chosen = [group for group in found if arguments.write in (None, group.group_id)]
    if arguments.write and not chosen:
        raise CommandError(
            f"aucun groupe « {arguments.write} ». Groupes : {', '.join(group.group_id for group in found)}."
        )
    if not found:
        print(f"{exercise.id} : rien de ce qui échoue n’est sans nom.")
        return 0
    with local_grader(course, probing) as grader:
        for group in chosen:
            _print_group(group, exercise, grader, write=bool(arguments.write))
    return 0


def _find_unexplained_groups(arguments: Namespace, exercise: Exercise) -> Sequence[UnexplainedGroup]:
    with open_database(read_settings(data_dir=arguments.data)) as database, database.read() as db:
        return study.load_unexplained_groups(db, exercise.id, arguments.most)


def _print_group(group: UnexplainedGroup, exercise: Exercise, grader: SandboxGrader, *, write: bool) -> None:
    try:
        program = study.minimise_program(group, exercise, grader)
    except Invalid as refused:
        program = f"# {refused}\n"
    name = f" — « {group.description.title} », dit un enseignant" if group.description else ""
    older = "" if group.version == exercise.version else " (d’une autre version de l’exercice)"
    print(f"{group.group_id} : {study.describe_frequency(group)}{older}{name}")
    for change, count in group.changes:
        print(f"  réparé en changeant : {change} ({count} essai{'s' * (count > 1)})")
    for line in study.describe_counterexample(group):
        print(f"  {line}")
    print("".join(f"    {line}\n" for line in program.splitlines()))
    if write:
        try:
            files = study.write_misconception(group, exercise, program)
        except study.MisconceptionWriteError as refused:
            raise CommandError(f"{refused}.") from refused
        print("\n".join(os.path.relpath(path) for path in files))
        print("Ce programme est d’un élève, et sera exécuté sans bac à sable : relisez-le, puis dites-le en tête.")
        print(f"Dites-la en mots, puis : balise check {exercise.id}")
