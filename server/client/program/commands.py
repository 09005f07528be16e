"""The command line of the client."""

from __future__ import annotations

import argparse
import json
import re
import sys
import time
from collections.abc import Iterator, Sequence
from getpass import getpass
from html import unescape
from pathlib import Path
from typing import Any

from . import report, tokens, vscode
from .connection import ServerConnection
from .errors import ClientError
from .exercises import find_exercise_id
from .french import FrenchParser
from .release import SERVER, VERSION

#: The first line that `get` writes, by which `submit` and `watch` know what a file is for.
MARKER = re.compile(r"^# balise: (\S+/\S+)\s*$", re.MULTILINE)
ANSWERS = ".json"
LOOK_SECONDS = 0.5
TAG = re.compile(r"<[^>]+>")
BLANK_LINES = re.compile(r"\n\s*\n+")


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; return its exit status: 0 full marks, 1 less, 2 where it cannot be done."""
    arguments = _parser().parse_args(argv)
    try:
        return int(arguments.run(arguments))
    except ClientError as error:
        print(f"balise : {error}", file=sys.stderr)
        return report.CANNOT
    except KeyboardInterrupt:
        return 130


def _parser() -> FrenchParser:
    parser = FrenchParser(prog="balise.pyz", description="Envoie vos programmes à Balise.")
    version = f"balise.pyz {VERSION}"
    parser.arguments.add_argument("--version", action="version", version=version, help="affiche la version")
    commands = parser.add_subparsers(title="commandes", metavar="COMMANDE", required=True)

    def add(name: str, run: Any, help_text: str) -> Any:
        command = commands.add_parser(name, help=help_text, description=help_text)
        address = "adresse du serveur (%(default)s)"
        command.arguments.add_argument("--server", default=SERVER, metavar="URL", help=address)
        command.set_defaults(run=run)
        return command.arguments

    add("login", _run_login, "garde le jeton créé sur la page « Mon compte »")
    add("list", _run_list_exercises, "liste les exercices")
    get = add("get", _run_get_exercise, "écrit l’énoncé et le code de départ, ou votre dernier envoi")
    get.add_argument("exercise", metavar="EXERCICE")
    get.add_argument("--last", action="store_true", help="votre dernier envoi, au lieu du code de départ")
    submit = add("submit", _run_submit, "envoie un fichier et affiche le verdict")
    submit.add_argument("names", nargs="+", metavar="[EXERCICE] FICHIER")
    submit.add_argument("--problems", action="store_true", help="une ligne par échec, pour un éditeur")
    submit.add_argument("--json", action="store_true", help="le verdict en JSON")
    watch = add("watch", _run_watch, "envoie le fichier chaque fois que vous l’enregistrez")
    watch.add_argument("names", nargs="+", metavar="[EXERCICE] FICHIER")
    add("vscode", _run_write_vscode_tasks, "écrit une tâche pour VS Code dans ce dossier")
    return parser


def _connect(arguments: argparse.Namespace) -> ServerConnection:
    server = str(arguments.server).rstrip("/")
    if not server:
        raise ClientError("à quel serveur ? Donnez --server URL.")
    return ServerConnection(server, tokens.find_token(server))


def _run_login(arguments: argparse.Namespace) -> int:
    server = str(arguments.server).rstrip("/")
    if sys.stdin.isatty():
        token = getpass(f"Jeton créé sur {server}/compte (rien ne s’affiche) : ").strip()
    else:
        token = sys.stdin.readline().strip()
    if not token:
        raise ClientError("aucun jeton n’a été donné.")
    ServerConnection(server, token).list_exercises()
    tokens.save_token(server, token)
    print(f"Jeton gardé dans {tokens.token_file_path()}, que vous seul pouvez lire.")
    return 0


def _run_list_exercises(arguments: argparse.Namespace) -> int:
    exercises = _connect(arguments).list_exercises()
    width = max((len(exercise["id"]) for exercise in exercises), default=0)
    for exercise in exercises:
        print(f"{exercise['id']:<{width}}  {exercise['title']}")
    return 0


def _run_get_exercise(arguments: argparse.Namespace) -> int:
    connection = _connect(arguments)
    name = find_exercise_id(connection, arguments.exercise)
    exercise = connection.load_exercise(name)
    if exercise["kind"] != "code":
        raise ClientError(f"« {name} » se fait sur sa page : {connection.server}/{exercise['module']}")
    code = connection.load_last_submitted_file(name)["code"] if arguments.last else exercise["starter"]
    marker = f"# balise: {name}\n"
    _write_without_overwriting(Path(f"{exercise['slug']}.py"), code if MARKER.search(code) else marker + code)
    statement = "\n\n".join(
        (exercise["title"], _html_to_plain_text(exercise["statement_html"]), *_describe_accepted_answers(exercise))
    )
    _write_without_overwriting(Path(f"{exercise['slug']}.txt"), f"{statement}\n")
    return 0


def _describe_accepted_answers(exercise: dict[str, Any]) -> Iterator[str]:
    """Yield what is accepted of each function; nothing where the service does not say it."""
    for function in exercise["functions"]:
        lines = [f"- {promise['label']} : {promise['text']}" for promise in function.get("promises", ())]
        if lines:
            yield "\n".join((f"Ce qui est accepté de {function['name']} :", *lines))


def _write_without_overwriting(file: Path, text: str) -> None:
    if file.exists() and file.read_text(encoding="utf-8") != text:
        raise ClientError(f"{file} existe déjà : déplacez-le d’abord, rien n’est remplacé.")
    file.write_text(text, encoding="utf-8")
    print(f"{file} écrit.")


def _html_to_plain_text(statement_html: str) -> str:
    """The text of a statement; its page has the mathematics and the figures."""
    text = re.sub(r"(?is)<(script|style|annotation).*?</\1>", "", statement_html)
    text = re.sub(r"(?i)</(p|li|h\d|tr|div|pre)>", "\n", text)
    return BLANK_LINES.sub("\n\n", unescape(TAG.sub("", text))).strip()


def _run_submit(arguments: argparse.Namespace) -> int:
    connection = _connect(arguments)
    exercise, file = _find_exercise_and_file(connection, arguments.names)
    return _submit_and_print_verdict(connection, exercise, file, arguments)


def _submit_and_print_verdict(
    connection: ServerConnection, exercise: str, file: Path, arguments: argparse.Namespace
) -> int:
    submission = connection.wait_until_graded_or_held(connection.submit(exercise, _read_submission_content(file)))
    if getattr(arguments, "json", False):
        print(json.dumps(submission, ensure_ascii=False))
    elif getattr(arguments, "problems", False):
        print(
            "\n".join(
                [
                    *report.problem_matcher_lines(submission, str(file.resolve())),
                    connection.attempt_page_url(submission),
                ]
            )
        )
    else:
        print(report.render_verdict(submission, connection.attempt_page_url(submission)))
    return report.exit_status_of_verdict(submission)


def _run_watch(arguments: argparse.Namespace) -> int:
    connection = _connect(arguments)
    exercise, file = _find_exercise_and_file(connection, arguments.names)
    print(f"{file} est envoyé à {exercise} à chaque enregistrement ; Ctrl+C pour arrêter.", flush=True)
    for _ in _iterate_saved_contents(file):
        try:
            _submit_and_print_verdict(connection, exercise, file, arguments)
        except ClientError as error:
            print(f"balise : {error}", file=sys.stderr)
        sys.stdout.flush()
    return 0


def _iterate_saved_contents(file: Path) -> Iterator[bytes]:
    """Yield the content of a file, then each new one."""
    before = None
    while True:
        try:
            content = file.read_bytes()
        except OSError:
            content = before or b""
        if content and content != before:
            before = content
            yield content
        time.sleep(LOOK_SECONDS)


def _run_write_vscode_tasks(_arguments: argparse.Namespace) -> int:
    tasks = vscode.write_vscode_tasks(Path.cwd(), Path(sys.argv[0]).resolve())
    print(f"{tasks} écrit : Ctrl+Maj+B envoie le fichier ouvert.")
    return 0


def _read_submission_content(file: Path) -> dict[str, Any]:
    text = _read_utf8_file(file)
    if file.suffix != ANSWERS:
        return {"code": text}
    try:
        return {"answers": json.loads(text)}
    except ValueError as error:
        raise ClientError(f"{file} n’est pas du JSON : {error}.") from error


def _read_utf8_file(file: Path) -> str:
    try:
        return file.read_bytes().decode("utf-8-sig")
    except FileNotFoundError as error:
        raise ClientError(f"{file} n’existe pas dans le dossier {Path.cwd()}.") from error
    except OSError as error:
        raise ClientError(f"{file} ne se lit pas : {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise ClientError(f"{file} n’est pas un texte en UTF-8 (octet {error.start + 1}).") from error


def _find_exercise_and_file(connection: ServerConnection, names: list[str]) -> tuple[str, Path]:
    """Find the exercise: named first, else by the first line of the file, else by the file's name."""
    if len(names) > 2:
        raise ClientError("donnez l’exercice et le fichier, ou le fichier seul.")
    file = Path(names[-1])
    if len(names) == 2:
        return find_exercise_id(connection, names[0]), file
    marked = MARKER.search(_read_utf8_file(file))
    return find_exercise_id(connection, marked[1] if marked else file.stem), file
