"""`balise export MODULE FILE`: the module as one archive that opens without a server, drawn and written here."""

from argparse import Namespace

from server.cli import CannotRun
from server.cli.local import load_course
from server.cli.progress import Progress
from server.offline import site
from server.reading.downloads import Downloads


def run(arguments: Namespace) -> int:
    course = load_course()
    module = course.modules.get(arguments.module)
    if module is None:
        raise CannotRun(f"le module « {arguments.module} » n’existe pas. Modules : {', '.join(course.modules)}.")
    with Progress("Figures", len(site.pictured(module))) as progress:
        pictures = site.drawn_here(module, progress.advance)
    made = site.archive(course, module, pictures, Downloads(course))
    try:
        arguments.file.write_bytes(made)
    except OSError as error:
        raise CannotRun(f"impossible d’écrire « {arguments.file} » : {error.strerror}.") from error
    print(f"{arguments.file} : {len(made) / 1e6:.1f} Mo. Décompressez, puis ouvrez {site.folder(module)}/index.html.")
    return 0
