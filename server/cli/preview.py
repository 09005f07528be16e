"""`balise preview [MODULE|DIR]`: a course as it is written, on this machine alone."""

import os
import signal
import socket
from argparse import Namespace
from pathlib import Path
from types import FrameType

from graders import courses
from server.cli import CommandError, add_course_folder
from server.cli.sandboxes import require_safe_sandbox, start_probing_walls
from server.course.editions import MODULE_SLUG

LOCALHOST = "127.0.0.1"
BACKLOG = 128


def run(arguments: Namespace) -> int:
    place, module = _find_course_and_module(arguments.what)
    signal.signal(signal.SIGTERM, _raise_system_exit)
    probing = start_probing_walls(slow=False)
    with _open_listening_socket(arguments.port) as listener:
        # Imported once, here: what is forked for each version of the files then has only the author's code to import.
        from server.authoring.preview import faults, serving
        from server.authoring.preview.supervising import PreviewSupervisor

        require_safe_sandbox(probing)
        address = f"http://{LOCALHOST}:{listener.getsockname()[1]}/{module}"
        print(f"Aperçu de {os.path.relpath(place)} : {address}", flush=True)
        print("  Chaque changement se voit aussitôt. Ctrl+C pour arrêter.\n", flush=True)
        PreviewSupervisor(
            place, listener, serving.serve_version, faults.check_course_and_write_faults, _print_now
        ).run()
    return 0


def _raise_system_exit(_signal: int, _frame: FrameType | None) -> None:
    """Being asked to stop is no failure: what was kept meanwhile goes, and the processes with it."""
    raise SystemExit(0)


def _print_now(text: str) -> None:
    print(text, flush=True)


def _find_course_and_module(what: str | None) -> tuple[Path, str]:
    """The course's folder, and the module to begin with, if one was named."""
    if what is None:
        outside = courses.COURSES.folders[1:]
        here = Path.cwd()
        return (outside[0] if outside else here if _is_course_folder(here) else courses.REPOSITORY), ""
    if MODULE_SLUG.fullmatch(what) and courses.module_folder(what).is_dir():
        return courses.module_folder(what).parents[1], what
    place = Path(what)
    if not place.is_dir():
        raise CommandError(f"« {what} » n’est ni un module, ni le dossier d’un cours.")
    add_course_folder(place)
    return place.resolve(), ""


def _is_course_folder(folder: Path) -> bool:
    return (folder / courses.CURRICULUM).is_dir() and folder.resolve() in courses.COURSES.folders


def _open_listening_socket(port: int) -> socket.socket:
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((LOCALHOST, port))
    except OSError as error:
        raise CommandError(f"le port {port} n’est pas libre : choisissez-en un autre avec --port.") from error
    listener.listen(BACKLOG)
    return listener
