"""Kits on the disk, and as our own code finds them in this process."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from graders.core.contract import local
from graders.core.contract.kits import find_kits, kit_module_name
from graders.core.contract.local import LOCAL
from graders.core.contract.program import KitSettings, StudentFault

FILES = {
    "m9.py": "def configurer(seed=0):\n    return {'graine': seed}\n",
    "monde/monde.py": "import m9\nfrom moteur import TOUR\ndef configurer(seed=0):\n"
    "    conduire = lambda fabrique, n: fabrique().rouler(n) + TOUR\n"
    "    return {**m9.configurer(seed), '__drivers__': {'Robot': conduire}}\n",
    "monde/moteur/__init__.py": "from .roue import TOUR\n",
    "monde/moteur/roue.py": "TOUR = 4\n",
    "autre/notes.py": "",
}


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    folder = tmp_path / "curriculum" / "m9"
    for name, text in FILES.items():
        path = folder / "kit" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.setattr(local, "_curriculum_folders", lambda: [tmp_path / "curriculum"])
    for cached in (local._owning_module_folder, local._import_kit_modules):
        cached.cache_clear()
    yield folder
    for cached in (local._owning_module_folder, local._import_kit_modules):
        cached.cache_clear()


def test_a_folder_with_a_module_of_its_name_is_a_kit_and_holds_the_module_s_own(module: Path) -> None:
    found = find_kits(module)
    assert {name: list(files) for name, files in found.items()} == {
        "m9": ["m9.py"],
        "monde": ["m9.py", "monde.py", "moteur/__init__.py", "moteur/roue.py"],
    }
    assert [kit_module_name(path) for path in found["monde"]] == ["m9", "monde", "moteur", "moteur.roue"]


def test_our_own_code_imports_its_kit_and_is_driven(module: Path) -> None:
    source = b"import moteur.roue\nfrom moteur import roue\nimport json\nclass Robot:\n    def rouler(self, n):\n"
    source += b"        import m9\n        return n * moteur.TOUR + graine + roue.TOUR + m9.configurer()['graine']\n"
    program = LOCAL.open(source, KitSettings("monde", {"seed": 100}))
    assert program.call("Robot", 2).value == 116
    assert not sys.modules.keys() & {"m9", "monde", "moteur", "moteur.roue"}
    assert not [place for place in sys.path if place.startswith(str(module))]
    with pytest.raises(ModuleNotFoundError):
        LOCAL.open(b"import moteur\n", KitSettings("m9", {}))
    with pytest.raises(StudentFault, match="ZeroDivisionError"):
        LOCAL.open(b"class Robot:\n    def rouler(self, n): return 1 / 0\n", KitSettings("monde", {})).call("Robot", 1)
