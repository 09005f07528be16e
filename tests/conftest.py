"""What tests of several rooms share."""

from __future__ import annotations

import gc
import importlib
import os
import re
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: the processes of xdist share the processors already
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # thirty processes are started: what one compiles serves all

import shutil
import tempfile
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from _pytest.runner import runtestprotocol
from hypothesis import HealthCheck, settings

if TYPE_CHECKING:
    from server.sandbox import Sandbox

#: What tests of several rooms ask for: the service with the real course, and a small course that is written.
SHARED = ("tests.support.service", "tests.support.small_course", "tests.support.write_lock")

#: A file system in memory, where a synchronised write costs nothing, and what it must have left to be used.
MEMORY, MEMORY_BYTES = Path("/dev/shm"), 4 << 30

TESTS = Path(__file__).parent
#: The folders whose tests carry the marker of their name; all the others are the platform's.
PARTS = ("content", "contract")
#: Fixtures that start a program of others: a test of the platform that asks for one is marked as a contract.
STARTS_A_SERVER = {"postgres_server", "postgres_url"}

sys.dont_write_bytecode = False
gc.disable()  # until all is imported and collected

# A busy machine is no failure.
settings.register_profile("balise", deadline=None, max_examples=25, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("balise")


def pytest_configure(config: pytest.Config) -> None:
    """Not for the process of xdist that runs no test: the others wait for it, and these import the whole service."""
    _use_memory_for_temporary_files(config)
    runs_tests = config.getoption("dist", "no") == "no" or hasattr(config, "workerinput")
    if runs_tests or config.option.collectonly:
        for plugin in SHARED:
            config.pluginmanager.import_plugin(plugin)


def _use_memory_for_temporary_files(config: pytest.Config) -> None:
    """Put temporary files into memory, unless `TMPDIR` says where: a database writes to the disk at each commit.

    Processes of xdist, servers and PostgreSQL inherit the folder. It may be entered by others, as `/tmp`.
    """
    if "TMPDIR" in os.environ or not _has_room(MEMORY):
        return
    for left in MEMORY.glob("balise-tests-*"):  # by a run that was killed
        if not Path("/proc", left.name.split("-")[2]).exists():
            shutil.rmtree(left, ignore_errors=True)
    folder = tempfile.mkdtemp(prefix=f"balise-tests-{os.getpid()}-", dir=MEMORY)
    Path(folder).chmod(0o1777)
    os.environ["TMPDIR"] = tempfile.tempdir = folder
    config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))


def _has_room(folder: Path) -> bool:
    """Whether a folder has room for a whole run, whose programs may be run from there."""
    try:
        state = os.statvfs(folder)
    except OSError:
        return False
    is_executable = not state.f_flag & os.ST_NOEXEC
    return is_executable and os.access(folder, os.W_OK) and state.f_bavail * state.f_frsize > MEMORY_BYTES


#: Processes of xdist, where a machine has many processors: each collects all tests, and most of them start servers.
MAX_WORKERS = 8
#: A selection of so few files is run in this process: each other one loads the course and the routes for itself, which
#: takes longer than the tests do.
SMALL_SELECTION_FILES = 10


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int | None:
    """None for a small selection; else one more than there are processors, as tests wait for a fifth of the time."""
    if "PYTEST_XDIST_AUTO_NUM_WORKERS" in os.environ:
        return None
    if len(_selected_paths(config)) <= SMALL_SELECTION_FILES:
        config.option.dist = "no"
        return 0
    return min(len(os.sched_getaffinity(0)) + 1, MAX_WORKERS)


def _selected_paths(config: pytest.Config) -> set[Path]:
    """Return the test files of a selection, without those of the parts that it leaves out."""
    paths = {config.invocation_params.dir / argument.split("::")[0] for argument in config.args}
    files = {file for path in paths for file in ([path] if path.is_file() else path.rglob("test_*.py"))}
    left_out = {TESTS / part for part in _left_out_parts(config)}
    return {file for file in files if left_out.isdisjoint(file.parents)}


def _left_out_parts(config: pytest.Config) -> set[str]:
    """Return the parts that a selection leaves out, as `-m "not content"` does."""
    expression = config.option.markexpr
    return set() if " or " in expression else {*re.findall(r"\bnot (\w+)", expression)} & {*PARTS}


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Skip the folder of a part that the selection leaves out (`-m "not content"`): nothing of it is imported."""
    is_left_out = collection_path.parent == TESTS and collection_path.name in _left_out_parts(config)
    return True if is_left_out else None


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Iterator[None]:
    """What is collected stays to the end: the collector of garbage does not walk through it again and again.

    Nor does it look so often at all that the tests keep: a full collection takes a tenth of a second by then.
    """
    if hasattr(session.config, "workerinput"):
        _import_share(session.config)
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(50_000, 10, 20)
        gc.enable()


def _import_share(config: pytest.Config) -> None:
    """Import this process's share of the test files that nobody has compiled yet, as in a fresh checkout.

    All processes collect in one order: each would rewrite the assertions of every file at the same time as the others.
    """
    position, count = int(config.workerinput["workerid"].removeprefix("gw")), config.workerinput["workercount"]
    for path in sorted(_selected_paths(config))[position::count]:
        if any(path.parent.glob(f"__pycache__/{path.stem}.*-pytest-*.pyc")):
            continue
        try:
            importlib.import_module(".".join(path.relative_to(TESTS.parent).with_suffix("").parts))
        except (Exception, pytest.skip.Exception):
            continue  # the collection meets it again, and tells it


@pytest.hookimpl(tryfirst=True)
def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark each test by the part of the suite in which its folder lies, or by the server that its fixtures start."""
    part = _part_of(item)
    if part in PARTS:
        item.add_marker(part)
    elif isinstance(item, pytest.Function) and not STARTS_A_SERVER.isdisjoint(item.fixturenames):
        item.add_marker("contract")


def _part_of(item: pytest.Item) -> str:
    return item.nodeid.split("/")[1]


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out slow tests, unless they are asked for, and put the others in order.

    Each worker begins with one piece of the list: the content, whose graders and templates take seconds to warm up, is
    in as few of them as can be, and so are the servers of the contracts. Long tests come first of their part: begun
    last, one would keep a processor busy while the others have nothing to do. Those of the platform come first of all,
    as mypy without a cache takes a minute.
    """
    if "slow" not in config.option.markexpr:
        config.hook.pytest_deselected(items=[item for item in items if item.get_closest_marker("slow")])
        items[:] = [item for item in items if not item.get_closest_marker("slow")]
    order = {part: position for position, part in enumerate(PARTS)}

    def rank(item: pytest.Item) -> tuple[int, bool]:
        part, is_long = order.get(_part_of(item)), item.get_closest_marker("long") is not None
        if part is None:
            return (-1 if is_long else len(PARTS), not is_long)
        return (part, not is_long)

    items.sort(key=rank)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """A process of xdist tells the other one message a test, not five: how it ended, and what failed around it.

    What is set up and taken down in good order is told when somebody asks how long it takes.
    """
    options = item.config.option
    if (
        not hasattr(item.config, "workerinput")
        or options.durations is not None
        or options.xmlpath
        or options.verbose > 0
    ):
        return None
    for report in runtestprotocol(item, log=False, nextitem=nextitem):
        if report.when == "call" or not report.passed:
            item.ihook.pytest_runtest_logreport(report=report)
    return True


@pytest.hookimpl(wrapper=True)
def pytest_report_to_serializable(report: pytest.CollectReport | pytest.TestReport) -> Generator[None, Any, Any]:
    """A failure that shows half a character (hypothesis finds them) is told: it would end the process that tells it."""
    serialized = yield
    return serialized if report.passed else _sendable(serialized)


def _sendable(value: Any) -> Any:
    match value:
        case str():
            return value.encode("utf-8", "backslashreplace").decode("utf-8")
        case dict():
            return {_sendable(key): _sendable(member) for key, member in value.items()}
        case list() | tuple():
            return type(value)(map(_sendable, value))
        case _:
            return value


@pytest.fixture(scope="session")
def course_sandbox() -> Iterator[Sandbox]:
    """The sandbox of the course, with its templates: one for all that only need it to grade or to run."""
    from server.sandbox import Sandbox
    from tests.support.quick import the_course

    with Sandbox(the_course().kits) as sandbox:
        yield sandbox
