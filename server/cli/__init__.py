"""The command line, where each command is a module that is imported only when it is asked for."""

import argparse
import gc
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path

from server.base.version import VERSION
from server.cli import authors, options
from server.cli.french import translate_argparse
from server.cli.options import parse_bounded_integer

CANNOT = 2
Command = Callable[[argparse.Namespace], int]


class CommandError(Exception):
    """A command that cannot do its work; its message is French and for the user. Exit status 2."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; return its exit status."""
    arguments = _build_parser().parse_args(argv, argparse.Namespace(alone=argv is None))
    try:
        add_course_folder(getattr(arguments, "course", None))
        with imports_without_garbage_collection(arguments):
            command: Command = import_module(f"server.cli.{arguments.command}").run
        return command(arguments)
    except CommandError as reason:
        print(f"balise : {reason}", file=sys.stderr)
        return CANNOT
    except BrokenPipeError:
        sys.stderr.close()  # whoever was reading has stopped: nothing left to say
        return CANNOT
    except KeyboardInterrupt:
        return 130


def add_course_folder(course: Path | None) -> None:
    """Add the course of a folder, in this process and its children. Raises CommandError."""
    if course is not None:
        from graders.courses import COURSES, ENVIRONMENT_VARIABLE, add_course

        os.environ[ENVIRONMENT_VARIABLE] = os.pathsep.join(
            filter(None, (str(course.resolve()), os.environ.get(ENVIRONMENT_VARIABLE)))
        )
        add_course(course)
        if course.resolve() not in COURSES.folders:
            raise CommandError(
                "ce cours n’est pas pris :"
                + "".join(f"\n  {problem.path} : {problem.message}" for problem in COURSES.problems)
            )


@contextmanager
def imports_without_garbage_collection(arguments: argparse.Namespace) -> Iterator[None]:
    """Import without garbage collection (a sixth of the time); `alone`: the process is for this command."""
    gc.disable()
    try:
        yield
    finally:
        if arguments.alone:
            gc.freeze()
        gc.enable()


def _build_parser() -> argparse.ArgumentParser:
    translate_argparse()
    parser = argparse.ArgumentParser(prog="balise", description="Plateforme de cours à correction automatique.")
    parser.add_argument(
        "--version", action="version", version=f"balise {VERSION}", help="écrit la version, et s’arrête"
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMANDE")
    _add_serve_options(commands.add_parser("serve", help="lance tout le service", description="Lance tout le service."))
    help_text = "lance le service avec une classe fictive, dont une séance est en cours, pour visiter"
    _add_demo_options(commands.add_parser("demo", help=help_text, description=f"{help_text.capitalize()}."))
    _add_grade_options(commands.add_parser("grade", help="corrige un fichier, sans serveur"))
    _add_check_options(
        commands.add_parser("check", help="vérifie les exercices eux-mêmes (références, erreurs cataloguées)")
    )
    authors.add_author_commands(commands)
    doctor = commands.add_parser("doctor", help="dit quelles protections du bac à sable tiennent sur cette machine")
    help_text = "regarde plutôt ce que plusieurs machines partagent : base, NATS, horloges, correcteurs"
    doctor.add_argument("--cluster", action="store_true", help=help_text)
    _add_submit_options(commands.add_parser("submit", help="envoie un fichier à un serveur et suit sa correction"))
    _add_login_options(
        commands.add_parser(
            "login", help="garde un jeton pour « balise submit », lu au clavier ou sur l’entrée standard"
        )
    )
    help_text = "écrit tout ce qui se lit d’un module dans une archive ZIP, qui s’ouvre sans serveur"
    _add_export_options(commands.add_parser("export", help=help_text, description=f"{help_text.capitalize()}."))
    commands.add_parser(
        "worker", help="corrige pour un serveur, depuis une autre machine (BALISE_DATABASE_URL, BALISE_NATS_URL)"
    )
    help_text = "montre ce que fait le service en ce moment, et le rafraîchit"
    options.add_top_options(commands.add_parser("top", help=help_text, description=f"{help_text.capitalize()}."))
    help_text = "sauvegarde la base de données, le service allant son cours, et vérifie la sauvegarde"
    options.add_backup_options(commands.add_parser("backup", help=help_text, description=f"{help_text.capitalize()}."))
    help_text = "remet une sauvegarde à la place de la base de données, le service étant arrêté"
    options.add_restore_options(
        commands.add_parser("restore", help=help_text, description=f"{help_text.capitalize()}.")
    )
    help_text = (
        "copie toutes les données d’une base vers une autre, vide, SQLite ou PostgreSQL, le service étant arrêté"
    )
    options.add_move_options(commands.add_parser("move", help=help_text, description=f"{help_text.capitalize()}."))
    options.add_admin_options(commands.add_parser("admin", help="ce que fait un administrateur"))
    return parser


def _add_demo_options(parser: argparse.ArgumentParser) -> None:
    _add_address_options(parser)
    help_text = "dossier des données, vide ; sans lui, un dossier temporaire, effacé à la fin"
    parser.add_argument("--data", type=Path, metavar="DIR", help=help_text)
    parser.add_argument(
        "--students", type=_parse_student_count, default=35, metavar="N", help="élèves (par défaut : %(default)s)"
    )
    parser.add_argument("--seed", type=_parse_seed, default=20, metavar="N", help="graine de l’histoire (%(default)s)")


def _add_address_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--host", default="127.0.0.1", help="adresse d’écoute (par défaut : %(default)s)")
    parser.add_argument(
        "--port", type=_parse_port, default=8000, help="port, 0 pour un port libre (par défaut : %(default)s)"
    )


def _add_serve_options(parser: argparse.ArgumentParser) -> None:
    _add_address_options(parser)
    parser.add_argument("--data", type=Path, metavar="DIR", help="dossier des données")
    help_text = "adresses ou réseaux des serveurs mandataires que l’on croit sur l’adresse des visiteurs"
    parser.add_argument("--trusted-proxy", metavar="ADDRESS[,…]", help=help_text)


def _add_grade_options(parser: argparse.ArgumentParser) -> None:
    _add_exercise_and_file_arguments(parser, nargs="?")
    authors.add_course_option(parser)
    parser.add_argument(
        "--questions", action="store_true", help="écrit les questions d’un exercice sans code, pour cette graine"
    )
    parser.add_argument("--json", action="store_true", help="n’écrit que le verdict, en JSON")
    help_text = "dossier de vos fichiers d’exercices réussis (poses.py, kabsch.py…), que « mes_fonctions » reprend"
    parser.add_argument("--reuse", type=Path, metavar="DIR", help=help_text)
    parser.add_argument(
        "--seed", type=_parse_seed, metavar="N", help="graine des tirages, pour refaire la même correction"
    )


def _add_check_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "exercises", nargs="*", metavar="MODULE|EXERCISE", help="modules ou exercices à vérifier (par défaut : tout)"
    )
    authors.add_course_option(parser)
    memory = parser.add_mutually_exclusive_group()
    help_text = "vérifie aussi ce qui était en ordre et n’a pas changé depuis"
    memory.add_argument("--fresh", "--all", action="store_true", help=help_text)
    help_text = "laisse de côté ce qui n’a pas changé, même en intégration continue (CI), où rien n’est retenu sinon"
    memory.add_argument("--remember", action="store_true", help=help_text)
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument(
        "--fairness",
        type=Path,
        metavar="DIR",
        help="corrige plutôt des programmes inconnus : DIR/EXERCICE/right/*.py et DIR/EXERCICE/wrong/*.py",
    )
    help_text = "corrige plutôt chaque solution changée en un endroit : les vérifications le voient-elles ?"
    instead.add_argument("--mutants", action="store_true", help=help_text)
    help_text = "avec --fairness, nombre de graines essayées pour chaque programme (par défaut : %(default)s)"
    parser.add_argument("--seeds", type=_parse_seed_count, default=3, metavar="N", help=help_text)


def _add_submit_options(parser: argparse.ArgumentParser) -> None:
    _add_exercise_and_file_arguments(parser)
    parser.add_argument(
        "--server", metavar="URL", help="adresse du serveur (sans elle, celui du dernier « balise login »)"
    )
    help_text = "jeton créé sur la page « Mon compte » (sans lui, BALISE_TOKEN, puis celui de « balise login »)"
    parser.add_argument("--token", help=help_text)


def _add_login_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--server", required=True, metavar="URL", help="adresse du serveur")


def _add_export_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("module", metavar="MODULE", help="module, comme l20")
    parser.add_argument("file", type=Path, metavar="FILE", nargs="?", help="archive à écrire")
    parser.add_argument(
        "--pdf", type=Path, metavar="DIR", help="dossier où écrire un PDF par page (il y faut un Chromium)"
    )


def _add_exercise_and_file_arguments(parser: argparse.ArgumentParser, nargs: str | None = None) -> None:
    parser.add_argument("exercise", metavar="EXERCISE", help="exercice, comme l20/poses")
    help_text = "fichier Python, ou - pour l’entrée standard ; fichier .json pour un exercice sans code"
    parser.add_argument("file", metavar="FILE", nargs=nargs, help=help_text)


def _parse_port(text: str) -> int:
    return parse_bounded_integer(text, 65535, "le port")


def _parse_seed(text: str) -> int:
    return parse_bounded_integer(text, 2**53 - 1, "la graine")


def _parse_student_count(text: str) -> int:
    return max(1, parse_bounded_integer(text, 800, "le nombre d’élèves"))


def _parse_seed_count(text: str) -> int:
    return max(1, parse_bounded_integer(text, 1000, "le nombre de graines"))
