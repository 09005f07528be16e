"""A sandbox on this machine, and whether it is safe. Nothing here reads the course: a template comes up meanwhile."""

from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress

from graders.core.contract.kits import find_kits
from graders.courses import CURRICULUM, room_folders
from server.cli import CommandError
from server.sandbox import Sandbox, SandboxFault, WallReport, WallStatus, is_safe_to_serve, probe
from server.sandbox.install import import_set_of

Probing = Future[list[WallReport]]


def start_probing_walls(*, slow: bool = True) -> Probing:
    """Probes the sandbox's walls in a thread (it takes seconds, mostly waiting) while other things are read.

    A command that runs one file of its user leaves out the `slow` assaults, which wait for a time limit.
    """
    pool = ThreadPoolExecutor(1)
    probing = pool.submit(probe, slow=slow)
    pool.shutdown(wait=False)
    return probing


def require_safe_sandbox(probing: Probing) -> list[WallReport]:
    """Waits for the probe; raises CommandError, with the walls that are missing, where it is not safe to run."""
    reports = probing.result()
    if not is_safe_to_serve(reports):
        missing = "".join(
            f"\n  {report.name} : {report.detail}\n    remède : {report.mend}"
            for report in reports
            if report.required and report.status != WallStatus.STANDING
        )
        raise CommandError(f"le bac à sable n’est pas sûr sur cette machine (voir « balise doctor ») :{missing}")
    return reports


@contextmanager
def sandbox_starting_early(exercise_id: str, source: bytes) -> Iterator[Future[Sandbox]]:
    """A sandbox for a program of an exercise, the template of which comes up while other things are read."""

    def start() -> Sandbox:
        sandbox = Sandbox(_read_kits_of_module(exercise_id.partition("/")[0]))
        with suppress(SandboxFault):  # told when the program meets it
            sandbox.warm(import_set_of(source))
        return sandbox

    with ThreadPoolExecutor(1) as pool:
        coming = pool.submit(start)
        try:
            yield coming
        finally:
            coming.result().close()


def _read_kits_of_module(slug: str) -> dict[str, dict[str, str]]:
    """The kits of a module, by name and place; none where there is no such module, which is told when it is read."""
    modules = (
        module for room in room_folders(CURRICULUM) if room.is_dir() for module in room.iterdir() if module.is_dir()
    )
    found = next((find_kits(module).items() for module in modules if module.name == slug), ())
    return {name: {place: path.read_text(encoding="utf-8") for place, path in kit.items()} for name, kit in found}
