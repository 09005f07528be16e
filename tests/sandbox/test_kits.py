"""A kit of several files: imported once, seen by who asks for it, and the drivers that it may give."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from server.sandbox import Kit, ProgramFault, Sandbox, SandboxFault

from .limits import FAR

SEVERAL = {
    "monde.py": "from moteur.roue import TOUR\ndef configurer(seed=0):\n"
    "    def conduire(fabrique, *tours):\n        return [fabrique().rouler(n) / TOUR for n in tours]\n"
    "    return {'TOUR': TOUR, '__drivers__': {'Robot': conduire}}\n",
    "moteur/__init__.py": "from . import roue\nfrom .roue import Roue\n",
    "moteur/roue.py": "TOUR = 4\nclass Roue:\n    def rouler(self, n):\n        return n * TOUR\n",
}
ALONE = "def configurer(seed=0):\n    return {'x': 3}\n"
ROBOT = b"""
import moteur.roue
from moteur import Roue
class Robot(Roue):
    pass
class Autre(Roue):
    def __init__(self, n):
        self.n = n
def lire(n):
    return n + TOUR, moteur.roue is __import__("moteur.roue", fromlist=["TOUR"])
def tours(n):
    return Autre(n).rouler(2)
"""


@pytest.fixture(scope="module")
def sandbox() -> Iterator[Sandbox]:
    with Sandbox({"seul": ALONE, "monde": SEVERAL}, FAR) as sandbox:
        yield sandbox


def test_a_package_is_found_and_a_name_is_called_by_its_driver(sandbox: Sandbox) -> None:
    with sandbox.open(ROBOT, kit=Kit("monde")) as session:
        assert session.call("Robot", 3, 5).value == [3.0, 5.0]
        assert session.call("lire", 1).value == (5, True)
        assert session.call("tours", 1).value == 8
    with pytest.raises(ProgramFault) as caught, sandbox.open(ROBOT, kit=Kit("seul")):
        pass
    assert "moteur" in caught.value.message
    assert caught.value.line == 2
    for asked, other in (("seul", "moteur"), ("monde", "seul")):
        source = f"import {asked}\ndef f():\n    import {other}\n".encode()
        with sandbox.open(source, kit=Kit(asked)) as session, pytest.raises(ProgramFault, match=other):
            session.call("f")


def test_what_a_driven_program_raises_is_told_with_its_line(sandbox: Sandbox) -> None:
    source = b"class Robot:\n    def rouler(self, n):\n        return 1 / 0\n"
    with sandbox.open(source, kit=Kit("monde")) as session, pytest.raises(ProgramFault) as caught:
        session.call("Robot", 1)
    assert caught.value.line == 3


def test_a_file_of_a_kit_that_is_not_python_is_our_fault() -> None:
    broken = {**SEVERAL, "moteur/roue.py": "def"}
    with Sandbox({"monde": broken}, FAR) as sandbox, pytest.raises(SandboxFault, match="SyntaxError"):
        sandbox.open(ROBOT, kit=Kit("monde"))
