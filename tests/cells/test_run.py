"""What a page shows of a cell, honest or hostile."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable
from dataclasses import replace

import pytest
from PIL import Image

from server.cells import run as cells
from server.cells.schemas import CellRunResult
from server.sandbox import Sandbox

PYPLOT = "import matplotlib.pyplot as plt\n"
PREFIX = "data:image/png;base64,"
Run = Callable[[str], CellRunResult]


#: The limits of cells, of which no limit of time is to decide.
FAR = replace(cells.POLICY, cpu_seconds=60.0, wall_seconds=300.0)


@pytest.fixture(scope="module")
def run(course_sandbox: Sandbox) -> Run:
    return lambda code: cells.run_cell(course_sandbox, "l20", code.encode())


@pytest.fixture(autouse=True)
def _far_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    """A program that closes its wire and ends is not to be killed meanwhile, either."""
    monkeypatch.setattr(cells, "POLICY", FAR)
    monkeypatch.setattr("server.sandbox.connection.GRACE_SECONDS", 60.0)


@pytest.fixture
def hurried(monkeypatch: pytest.MonkeyPatch) -> None:
    """For what never ends: whichever limit it meets, the outcome is the same."""
    monkeypatch.setattr(cells, "POLICY", replace(FAR, cpu_seconds=0.1, wall_seconds=0.5))
    monkeypatch.setattr("server.sandbox.connection.GRACE_SECONDS", 0.1)


def picture(address: str) -> Image.Image:
    assert address.startswith(PREFIX)
    image = Image.open(io.BytesIO(base64.b64decode(address.removeprefix(PREFIX), validate=True)))
    image.load()
    return image


def test_a_cell_finds_the_kit_prints_and_draws(run: Run) -> None:
    shown = run(
        PYPLOT + "print(H, W, PORTEE_MAX, libres.dtype)\nplt.imshow(libres)\nplt.plot(*lidar_lot([(3, 3, 0)], 9))"
    )
    assert (shown.stdout, shown.truncated, shown.fault) == ("16 24 12.0 bool\n", False, None)
    (address,) = shown.figures
    assert (picture(address).size, picture(address).info) == ((960, 720), {})


def test_the_same_cell_gives_the_same_numbers(run: Run) -> None:
    code = "import random\nprint(rng.random(), np.random.rand(), random.random())"
    assert run(code).stdout == run(code).stdout


def test_a_fault_is_told_with_its_line_its_way_and_what_was_printed_before(run: Run) -> None:
    shown = run("print('avant')\ndef inverse(x):\n    return 1 / x\ninverse(0)\n")
    assert shown.stdout == "avant\n"
    assert shown.fault is not None
    assert (shown.fault.title, shown.fault.line) == ("Erreur à l’exécution", 3)
    assert "Un diviseur est nul" in shown.fault.message
    assert shown.fault.frames == ["ligne 4 : inverse(0)", "ligne 3, dans inverse : return 1 / x"]


def test_a_fault_while_a_figure_is_drawn_leaves_the_prints(run: Run) -> None:
    shown = run(PYPLOT + "plt.title('$\\\\mauvais$')\nprint('avant')")
    assert (shown.stdout, shown.figures) == ("avant\n", [])
    assert shown.fault is not None


@pytest.mark.parametrize(
    ("code", "told"),
    [
        ("open('/etc/passwd')", "Fichiers, réseau, processus et fils d’exécution sont hors d’atteinte."),
        ("open('a.txt')", "Aucun fichier de données n’est fourni."),
        ("import seaborn", "Pour tracer, importez « matplotlib.pyplot »."),
    ],
)
def test_advice_is_for_a_reader_not_for_a_submission(run: Run, code: str, told: str) -> None:
    shown = run(code)
    assert shown.fault is not None
    assert told in shown.fault.message.replace("\u202f", " ")


@pytest.mark.parametrize(
    ("code", "printed"),
    [
        ("x = 3\n2 * x  # le double", "6\n"),
        ("print('avant')\n[1, 2][0]", "avant\n1\n"),
        ("np.eye(2)", "array([[1., 0.],\n       [0., 1.]])\n"),
        ("print(1)", "1\n"),
        ("def f():\n    5\nf()", ""),
        ("3\nx = 4", ""),
        ("list(range(9999))", str(list(range(9999)))[:4000] + "…\n"),
        (PYPLOT + "plt.plot([0, 1])", ""),
        (PYPLOT + "plt.subplots()", ""),
        ("", ""),
    ],
)
def test_a_last_expression_shows_its_value(run: Run, code: str, printed: str) -> None:
    shown = run(code)
    assert (shown.stdout, shown.fault) == (printed, None)


def test_a_last_expression_that_fails_says_its_line(run: Run) -> None:
    fault = run("x = 0\n1 / x").fault
    assert fault is not None
    assert (fault.line, fault.frames) == (2, ["ligne 2 : 1 / x"])
    mute = run("class A:\n    def __repr__(self):\n        return 1 / 0\nA()").fault
    assert mute is not None
    assert mute.line == 3


def test_what_is_printed_hides_nothing(run: Run) -> None:
    assert run("print('\\x1b[2J\\u202e<b>')").stdout == "␛[2J⟦U+202E⟧<b>\n"


ENDLESS = {
    "a loop": "while True: pass",
    "a loop in C": "sum(range(10**12))",
    "a sleep": "import time\ntime.sleep(60)",
    "a loop that hears nothing": (
        "import signal\nfor n in (14, 27): signal.signal(n, signal.SIG_IGN)\nwhile True: pass"
    ),
    "drawing without end": (
        PYPLOT + "class Lent(float):\n    def __float__(self):\n        while True: pass\n"
        "fig, ax = plt.subplots()\nax.draw = lambda *a: float(Lent())"
    ),
}
HOSTILE = {
    "memory": ("x = [0]\nwhile True: x += x", "Mémoire dépassée"),
    "an array": ("np.ones(10**9)", "Mémoire dépassée"),
    "a process": ("import os\nos.fork()", "Opération interdite"),
    "a command": ("import subprocess\nsubprocess.run(['ls'])", "Opération interdite"),
    "the network": ("import socket\nsocket.create_connection(('127.0.0.1', 80))", "Opération interdite"),
    "a file": ("open('/etc/passwd')", "Opération interdite"),
    "the project": (f"open({__file__!r})", "Opération interdite"),
    "the modules of ours": ("import server.sandbox", "Importation impossible"),
    "a system call": ("import ctypes\nctypes.CDLL(None).ptrace(0, 0, 0, 0)", "Opération interdite"),
    "the end": ("import os\nos._exit(0)", "Erreur à l’exécution"),
    "closed wires": ("import os\nos.closerange(0, 4096)", "Erreur à l’exécution"),
    "words on the wire": ("import os\nos.write(230, b'x' * 500)", "Résultat illisible"),
    "a syntax": ("def f(:", "Erreur de syntaxe"),
    "null": ("a = '\0'", "Erreur de syntaxe"),
}


@pytest.mark.usefixtures("hurried")
@pytest.mark.parametrize("code", ENDLESS.values(), ids=ENDLESS.keys())
def test_a_cell_without_end_is_ended(run: Run, code: str) -> None:
    shown = run(code)
    assert shown.fault is not None
    assert (shown.fault.title, shown.figures) == ("Temps dépassé", [])


@pytest.mark.parametrize(("code", "title"), HOSTILE.values(), ids=HOSTILE.keys())
def test_a_hostile_cell_gets_a_fault_and_nothing_else(run: Run, code: str, title: str) -> None:
    shown = run(code)
    assert shown.fault is not None
    assert (shown.fault.title, shown.figures) == (title, [])


def test_a_flood_is_cut(run: Run) -> None:
    shown = run("for _ in range(300): print('x' * 1000)")
    assert shown.truncated
    assert len(shown.stdout) <= cells.POLICY.stdout_bytes


def test_of_many_figures_four_are_shown(run: Run) -> None:
    shown = run("import warnings\nwarnings.simplefilter('ignore')\n" + PYPLOT + "for _ in range(100): plt.figure()")
    assert len(shown.figures) == 4
    assert "100 figures" in shown.stdout


CLIMB = """import sys
cadre = sys._getframe()
while cadre:
    if hasattr(cadre.f_globals.get("drawing"), "FIGURES"):
        cadre.f_globals["drawing"].render_open_figures = lambda: (np.frombuffer({bytes!r}, np.uint8),)
    cadre = cadre.f_back
"""
FORGED = {
    "markup": b"<svg xmlns='http://www.w3.org/2000/svg'/>",
    "a cut picture": b"\x89PNG\r\n\x1a\n",
    "nothing": b"",
}


@pytest.mark.parametrize("given", FORGED.values(), ids=FORGED.keys())
def test_a_forged_figure_is_refused(run: Run, given: bytes) -> None:
    shown = run("# matplotlib\n" + CLIMB.replace("{bytes!r}", repr(given)))
    assert shown.figures == []
    assert shown.fault is not None
    assert shown.fault.title == "Résultat illisible"


def test_replacing_what_saves_figures_forges_nothing(run: Run) -> None:
    code = PYPLOT + (
        "import matplotlib.figure\n"
        "matplotlib.figure.Figure.savefig = lambda self, f, **k: f.write(b'<script>alert(1)</script>')\nplt.figure()"
    )
    shown = run(code)
    assert shown.figures == []
    assert shown.fault is not None
    assert shown.fault.message == cells.UNREADABLE


def test_two_cells_share_nothing(run: Run) -> None:
    run("open('trace', 'w').write('x')\nimport builtins\nbuiltins.trace = np.trace_ = 1")
    shown = run("import os, builtins\nprint(os.listdir('.'), hasattr(builtins, 'trace'), hasattr(np, 'trace_'))")
    assert shown.stdout == "[] False False\n"
