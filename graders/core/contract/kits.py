"""The kits of a module on disk: the names and modules that its programs find.

The module's own kit is `kit/<module>.py`. A folder `kit/<name>/` is another kit: its files, packages included, and the
module's own file. A kit's main module has the kit's name. A module without a kit uses `plain_kit.py`.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

#: The default kit.
PLAIN = Path(__file__).with_name("plain_kit.py")
#: The kit of declared exercises, which every course has: its name, and its file.
SCENARIOS, SCENARIO_FILE = "scenarios", Path(__file__).with_name("scenario_kit.py")
#: The files of a kit by relative path: "l20.py", "rclpy/node.py".
Files = dict[str, Path]


def find_kits(module: Path) -> dict[str, Files]:
    """Return the files of each kit of a module's folder, the module's own kit first."""
    home = module / "kit"
    file = home / f"{module.name}.py"
    own = {file.name: file if file.is_file() else PLAIN}
    folders = sorted(path for path in home.iterdir() if _is_kit_folder(path)) if home.is_dir() else []
    return {module.name: own} | {folder.name: own | dict(_iter_python_files(folder)) for folder in folders}


def find_available_kits(module: Path) -> dict[str, Files]:
    """Return the files of each kit that an exercise of a module may ask for."""
    return find_kits(module) | {SCENARIOS: {f"{SCENARIOS}.py": SCENARIO_FILE}}


def scenario_kit() -> dict[str, dict[str, str]]:
    """Return the kit of declared exercises, with the source of its file."""
    return {SCENARIOS: {f"{SCENARIOS}.py": SCENARIO_FILE.read_text(encoding="utf-8")}}


def _is_kit_folder(path: Path) -> bool:
    return (path / f"{path.name}.py").is_file()


def _iter_python_files(folder: Path) -> Iterator[tuple[str, Path]]:
    for path in sorted(folder.rglob("*.py")):
        yield path.relative_to(folder).as_posix(), path


def kit_module_name(path: str) -> str:
    """Return the name by which a file of a kit is imported."""
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
