"""`balise demo`: the whole service, with a class of nobody whose lesson goes on, for who visits."""

import sys
import tempfile
from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fastapi import FastAPI

from server.base.app_services import get_service
from server.base.settings import Settings
from server.cli import CommandError
from server.cli.configuration import read_settings
from server.cli.local import local_grader
from server.cli.sandboxes import Probing
from server.cli.serve import serve
from server.course import Course
from server.database import Database
from server.demo.living import SimulatedLessonThread
from server.demo.loading import DemoClass, choose_demo_module, create_demo_class
from server.identity import repository as identity
from server.submissions.service import SubmissionService


def run(arguments: Namespace) -> int:
    with _open_data_folder(arguments.data) as folder:
        settings = read_settings(data_dir=folder)
        loaded: list[DemoClass] = []
        lessons: list[SimulatedLessonThread] = []

        def prepare(settings: Settings, course: Course, probing: Probing) -> None:
            loaded.append(_create_demo_class(settings, course, probing, arguments.seed, arguments.students))

        def announce(app: FastAPI, address: str) -> None:
            _print_addresses_and_passwords(loaded[0], address)
            lesson = SimulatedLessonThread(
                get_service(app, Database), get_service(app, Course), get_service(app, SubmissionService), loaded[0]
            )
            lesson.start()
            lessons.append(lesson)

        try:
            return serve(settings, arguments.host, arguments.port, announce, prepare)
        finally:
            for lesson in lessons:
                lesson.stop()


@contextmanager
def _open_data_folder(asked: Path | None) -> Iterator[Path]:
    if asked is not None:
        yield asked
        return
    with tempfile.TemporaryDirectory(prefix="balise-demo-") as folder:
        yield Path(folder)


def _create_demo_class(settings: Settings, course: Course, probing: Probing, seed: int, students: int) -> DemoClass:
    if not course.modules:
        raise CommandError("ce cours n’a pas de module.")
    database = Database(settings.sqlalchemy_url)
    try:
        with database.read() as db:
            if identity.count_accounts(db):
                raise CommandError(
                    "cette base de données sert déjà : la démonstration ne s’ajoute pas à de vrais comptes."
                )
        print("Une classe fictive s’écrit (quelques dizaines de secondes)…", file=sys.stderr, flush=True)
        with local_grader(course, probing) as grader:
            return create_demo_class(
                database,
                course,
                choose_demo_module(course),
                grader.grade,
                settings,
                seed=seed,
                students=students,
                report_progress=_print_progress,
            )
    finally:
        database.close()


def _print_progress(done: int, total: int) -> None:
    print(f"  {done} essais corrigés sur {total}", file=sys.stderr, flush=True)


def _print_addresses_and_passwords(loaded: DemoClass, address: str) -> None:
    (teacher, password), (student, other) = loaded.logins.items()
    print(f"\nBalise est prête : {address}/classes/{loaded.class_id}")
    print(f"  Enseignante : identifiant {teacher}, mot de passe {password}")
    print(f"  Un élève    : identifiant {student}, mot de passe {other}")
    print("  Une séance est en cours : le tableau de la classe bouge tout seul, pendant une heure environ.")
    print("  Ctrl+C pour arrêter.\n", flush=True)
