"""`balise export MODULE FILE`: the module as one archive that opens without a server; `--pdf DIR`: its texts as PDF."""

from argparse import Namespace
from pathlib import Path

from server.cli import CommandError
from server.cli.local import load_unrendered_course
from server.cli.progress import ProgressLine
from server.course import Course, Module
from server.offline import paper, site
from server.offline.site import Pictures
from server.reading.downloads import DownloadArchives

NO_BROWSER = (
    "il faut un Chromium pour écrire des PDF, et cette machine n’en a pas (cherchés : {names}). "
    "Sous Debian : apt install chromium. Sans lui, le bouton « Imprimer » de chaque page fait la même chose."
)


def run(arguments: Namespace) -> int:
    if arguments.file is None and arguments.pdf is None:
        raise CommandError("dites ce qu’il faut écrire : une archive (FILE), ou des PDF (--pdf DIR).")
    command = paper.find_chromium()
    if arguments.pdf is not None and command is None:
        raise CommandError(NO_BROWSER.format(names=", ".join(paper.BROWSERS)))
    course = load_unrendered_course()
    module = course.modules.get(arguments.module)
    if module is None:
        raise CommandError(f"le module « {arguments.module} » n’existe pas. Modules : {', '.join(course.modules)}.")
    with ProgressLine("Figures", len(site.list_needed_pictures(module))) as progress:
        pictures = site.draw_pictures_in_process(module, progress.advance)
    if arguments.file is not None:
        _export_archive(course, module, pictures, arguments.file)
    if arguments.pdf is not None and command is not None:
        _export_printable_papers(course, module, pictures, arguments.pdf, command)
    return 0


def _export_archive(course: Course, module: Module, pictures: Pictures, file: Path) -> None:
    made = site.build_archive_zip(course, module, pictures, DownloadArchives(course))
    try:
        file.write_bytes(made)
    except OSError as error:
        raise CommandError(f"impossible d’écrire « {file} » : {error.strerror}.") from error
    print(
        f"{file} : {len(made) / 1e6:.1f} Mo. Décompressez, puis ouvrez {site.archive_folder_name(module)}/index.html."
    )


def _export_printable_papers(course: Course, module: Module, pictures: Pictures, folder: Path, command: str) -> None:
    with ProgressLine("PDF", len(module.lessons)) as progress:
        try:
            made = paper.print_module_pdfs(course, module, pictures, folder, command=command, advance=progress.advance)
        except OSError as error:
            raise CommandError(f"impossible d’écrire dans « {folder} » : {error.strerror}.") from error
        except paper.PrintError as error:
            raise CommandError(f"{error}.") from error
    size = sum(path.stat().st_size for path in made)
    print(f"{folder} : {len(made)} PDF, {size / 1e6:.1f} Mo, corrigés compris.")
