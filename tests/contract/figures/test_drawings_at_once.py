"""A page asks for its figures at the same time: each must find the whole of the file that draws it."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Event

import pytest

from server.course.code import import_file

NAME = "curriculum.l20.figures.slow_to_load"


def test_a_module_half_loaded_by_one_thread_is_not_given_to_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "l20" / "figures" / "slow_to_load.py"
    path.parent.mkdir(parents=True)
    path.write_text("import sys\nsys.begun.set()\nsys.go_on.wait(0.5)\n\n\ndef draw():\n    pass\n", encoding="utf-8")
    begun, go_on = Event(), Event()
    monkeypatch.setattr(sys, "begun", begun, raising=False)
    monkeypatch.setattr(sys, "go_on", go_on, raising=False)
    monkeypatch.setitem(sys.modules, NAME, sys)  # so that what is loaded below is forgotten at the end
    monkeypatch.delitem(sys.modules, NAME)

    def can_draw() -> bool:
        return hasattr(import_file(path), "draw")

    with ThreadPoolExecutor(2) as threads:
        first = threads.submit(can_draw)
        assert begun.wait(300)
        second = threads.submit(can_draw)
        assert first.result()
        assert second.result()
