"""Walls that were tried are not tried again by `balise grade`, but where what they stand on has changed."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from server.cli import main, wall_cache


@pytest.fixture(autouse=True)
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file, which is kept."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    wall_cache.save_verified_walls()
    assert wall_cache.are_walls_recently_verified()
    return wall_cache.wall_cache_path()


def test_what_they_stand_on_is_all_that_may_change(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    changed = tmp_path / "changed"
    changed.write_text("another\n")
    for name in wall_cache.KERNEL_FILES:
        others = tuple(str(changed) if one == name else one for one in wall_cache.KERNEL_FILES)
        with monkeypatch.context() as patch:
            patch.setattr(wall_cache, "KERNEL_FILES", others)
            assert not wall_cache.are_walls_recently_verified(), name
    for name in wall_cache.STATUS_PREFIXES:
        with monkeypatch.context() as patch:
            patch.setattr(
                wall_cache, "STATUS_PREFIXES", tuple(one for one in wall_cache.STATUS_PREFIXES if one != name)
            )
            assert not wall_cache.are_walls_recently_verified(), name
    with monkeypatch.context() as patch:
        patch.setattr(wall_cache, "SANDBOX", tmp_path)
        assert not wall_cache.are_walls_recently_verified(), "the sandbox's own files"
    assert wall_cache.are_walls_recently_verified()


def rewritten(kept: Path, **values: Any) -> None:
    kept.write_text(json.dumps({**json.loads(kept.read_text()), **values}))


def linked(kept: Path) -> None:
    kept.rename(kept.with_suffix(".other"))
    kept.symlink_to(kept.with_suffix(".other"))


DOUBTS: dict[str, Callable[[Path], object]] = {
    "that others may write": lambda kept: kept.chmod(0o620),
    "in a folder that others may write": lambda kept: kept.parent.chmod(0o777),
    "that is a link": linked,
    "of two days ago": lambda kept: rewritten(
        kept, at=json.loads(kept.read_text())["at"] - 2 * wall_cache.MAX_AGE_SECONDS
    ),
    "of tomorrow": lambda kept: rewritten(kept, at=json.loads(kept.read_text())["at"] + wall_cache.MAX_AGE_SECONDS),
    "of no time": lambda kept: rewritten(kept, at=None),
    "of another ground": lambda kept: rewritten(kept, ground="0" * 64),
    "that is damaged": lambda kept: kept.write_text("{"),
    "that is another thing": lambda kept: kept.write_text("[3]"),
    "that is deeper than Python reads": lambda kept: kept.write_text("[" * 100_000),
    "that somebody never ends": lambda kept: (kept.unlink(), os.mkfifo(kept)),
    "that is gone": Path.unlink,
}


@pytest.mark.parametrize("doubt", DOUBTS)
def test_a_file_is_not_believed(doubt: str, kept: Path) -> None:
    DOUBTS[doubt](kept)
    assert not wall_cache.are_walls_recently_verified()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root gives a file away")
def test_a_file_of_somebody_else_is_not_believed(kept: Path) -> None:
    os.chown(kept, 61185, -1)
    assert not wall_cache.are_walls_recently_verified()


def test_what_was_not_sound_is_not_kept(kept: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    kept.unlink()
    monkeypatch.setattr("server.cli.sandboxes.Sandbox.warm", lambda *_: None)  # no program is run
    monkeypatch.setattr("server.cli.sandboxes.probe", lambda **_: [])
    program = tmp_path / "poses.py"
    program.write_text("")
    assert main(["grade", "l20/poses", str(program)]) == 2
    assert not kept.exists()
