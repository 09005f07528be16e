"""The kits of a module, on the disk: what its programs find.

The module's own is `kit/<module>.py`. A folder `kit/<name>/` is another one: its files, packages among them, and the
module's own file beside them, since what every program of the module finds is found there too. A kit's main module
bears its name. A module may have none: its programs then find what `plain_kit.py` gives.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

#: The kit of a module that has none.
PLAIN = Path(__file__).with_name("plain_kit.py")
#: The files of a kit, by where they stand in it: "l20.py", "rclpy/node.py".
Files = dict[str, Path]


def find_kits(module: Path) -> dict[str, Files]:
    """The kits of a module's folder, its own first."""
    home = module / "kit"
    file = home / f"{module.name}.py"
    own = {file.name: file if file.is_file() else PLAIN}
    folders = sorted(path for path in home.iterdir() if _is_kit(path)) if home.is_dir() else []
    return {module.name: own} | {folder.name: own | dict(_below(folder)) for folder in folders}


def _is_kit(path: Path) -> bool:
    return (path / f"{path.name}.py").is_file()


def _below(folder: Path) -> Iterator[tuple[str, Path]]:
    for path in sorted(folder.rglob("*.py")):
        yield path.relative_to(folder).as_posix(), path


def module_name(path: str) -> str:
    """What `import` calls a file of a kit."""
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
