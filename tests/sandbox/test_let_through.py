"""What is harmless in a file is let through with a remark; what is no program is called what it is."""

import pytest

from server.sandbox import FaultKind, Kit, ProgramFault, Sandbox, Session
from server.sandbox.child.notebook_text import clean_notebook_text
from server.sandbox.foreign_files import describe_foreign_file
from server.sandbox.remarks import parse_loaded

DOUBLE = "def f(x):\n    return 2 * x\n"


def opened(sandbox: Sandbox, source: str | bytes, **options: bool) -> Session:
    data = source if isinstance(source, bytes) else source.encode()
    return sandbox.open(data, kit=Kit("trousse", {"seed": 1}), **options)


def remarks(sandbox: Sandbox, source: str) -> list[str]:
    """The beginnings of the remarks on a file whose function doubles."""
    with opened(sandbox, source) as session:
        assert session.call("f", 2.0).value == 4.0
        return [remark.replace("\u00a0", " ") for remark in session.remarks]


DRAWINGS = {
    "figure": "import matplotlib.pyplot as plt\nfig, ax = plt.subplots()\nax.plot([0, 1])\nplt.show()\n",
    "several": "import matplotlib\nmatplotlib.use('Agg')\nfrom matplotlib import pyplot as plt\n"
    "fig, (a, b) = plt.subplots(1, 2)\nline, = a.plot([1])\nn, *rest = b.hist([1])\n"
    "for cell in plt.subplots(2, 2)[1].flat:\n    cell.set_title('x')\nwith plt.style.context('ggplot'):\n    pass\n",
    "numbers": "import matplotlib.pyplot as plt\nplt.plot(np.zeros(2) + 2 * plt.gca())\nplt.rcParams['x'] = 1\n",
    "three dimensions": "from mpl_toolkits.mplot3d import Axes3D\nimport matplotlib.animation as animation\n"
    "import matplotlib.pyplot as plt\nanimation.FuncAnimation(plt.figure(), lambda i: i, frames=3)\n",
    "stars": "from pylab import *\nplot(array([1, 2]), cos(0))\nshow()\n",
    "turtle": "from turtle import *\nforward(10)\nwhile xcor() > 5:\n    left(90)\ndone()\n",
    "window": "import tkinter as tk\nclass App(tk.Tk):\n    def __init__(self):\n        super().__init__()\n"
    "root = tk.Tk()\nroot.mainloop()\n",
    "seaborn": "import seaborn as sns\nsns.set_theme()\n",
    "decorated": "from ipywidgets import interact\n@interact(x=(0, 1))\ndef g(x):\n    return x\nassert g(3) == 3\n",
    "display": "from IPython.display import display, clear_output\ndisplay(1)\nclear_output()\n",
}  # fmt: skip


@pytest.mark.parametrize("beginning", DRAWINGS.values(), ids=DRAWINGS.keys())
def test_drawing_is_let_through(sandbox: Sandbox, beginning: str) -> None:
    (remark,) = remarks(sandbox, beginning + DOUBLE)
    assert "rien ne se trace pendant l’évaluation" in remark


def test_a_drawing_is_no_function_of_the_file_and_no_answer(sandbox: Sandbox) -> None:
    source = "import matplotlib.pyplot as plt\nfig, ax = plt.subplots()\ndef f(x):\n    return ax\n"
    with opened(sandbox, source) as session:
        assert session.functions == {"f"}
        with pytest.raises(ProgramFault) as caught:
            session.call("f", 1.0)
    assert (caught.value.kind, "« Dessin »" in caught.value.message.replace("\u00a0", " ")) == ("invalid_output", True)


NOTEBOOKS = {
    "magics": ("%matplotlib inline\n!pip install numpy\n%%time\n" + DOUBLE + "np.array?\nget_ipython()\n", 1),
    "indented": (DOUBLE + "if True:\n    %timeit f(2)\n", 4),
    "console": (">>> def f(x):\n...     y = 2 * x\n...     return y\n...\n>>> f(2)\n4\n>>> f([1])\n[1, 1]\n", 1),
    "after the code": (DOUBLE + "\n>>> f(2)\n4\n", 4),
    "numbered": (
        "In [1]: import numpy as np\n\nIn [2]: def f(x):\n   ...:     return 2 * x\n   ...: \n\nOut[3]: 4\n",
        1,
    ),
    "fences": ("```python\n" + DOUBLE + "```\n", 1),
}


@pytest.mark.parametrize(("source", "line"), NOTEBOOKS.values(), ids=NOTEBOOKS.keys())
def test_traces_of_a_notebook_are_let_through(sandbox: Sandbox, source: str, line: int) -> None:
    (remark,) = remarks(sandbox, source)
    assert remark.startswith(f"Ligne {line} : ")


@pytest.mark.parametrize(
    "source",
    [
        'def f(x):\n    """\n    >>> f(2)\n    4\n    %x\n    """\n    return 2 * x\n',
        "a = (5\n % 3)\n" + DOUBLE,
        DOUBLE,
    ],
)
def test_a_file_that_compiles_is_left_as_it_is(sandbox: Sandbox, source: str) -> None:
    assert remarks(sandbox, source) == []


def test_lines_keep_their_numbers(sandbox: Sandbox) -> None:
    with pytest.raises(ProgramFault) as caught:
        opened(sandbox, "%matplotlib inline\n\ndef f(x)\n    return x\n")
    assert (caught.value.line, "def f(x)" in caught.value.message) == (3, True)
    shifted = "!ls\n>>> x = 1\n" + DOUBLE.replace("2 * x", "x[0]")
    with opened(sandbox, shifted) as session, pytest.raises(ProgramFault, match="Ligne 4"):
        session.call("f", 2.0)
    text = "%a\r\n\r>>> b\n"
    assert len(clean_notebook_text(text)[0].splitlines()) == len(text.splitlines())


@pytest.mark.parametrize("call", ["exit()", "quit()", "import sys; sys.exit()", "exit(1)", "raise SystemExit"])
def test_an_exit_after_the_functions_ends_the_file(sandbox: Sandbox, call: str) -> None:
    (remark,) = remarks(sandbox, f"{DOUBLE}{call}\n1 / 0\n")
    assert remark.startswith("Ligne 3 : « exit »")


def test_an_exit_before_a_function_is_told(sandbox: Sandbox) -> None:
    with opened(sandbox, "def g():\n    pass\nexit()\n" + DOUBLE) as session, pytest.raises(ProgramFault) as caught:
        session.call("f", 1.0)
    assert caught.value.kind is FaultKind.MISSING_FUNCTION
    assert "arrêtée ligne 3" in caught.value.message
    with pytest.raises(ProgramFault, match="SystemExit"):
        opened(sandbox, "exit()\n" + DOUBLE)


FOREIGN = {
    "notebook": ('{\n "cells": [{"cell_type": "code", "source": []}],\n "nbformat": 4\n}', "carnet Jupyter"),
    "half a notebook": ('{"cells": [{"cell_type": "code", "source": [', "carnet Jupyter"),
    "data": ('{"poses": [1, 2]}', "données JSON"),
    "pdf": ("%PDF-1.7\n", "document PDF"),
    "word": (b"PK\x03\x04\x14\x00\x06\x00", "archive ZIP ou un document de traitement de texte"),
    "old word": (b"\xd0\xcf\x11\xe0\xa1\xb1", "document Word"),
    "rtf": ("{\\rtf1\\ansi def f}", "document RTF"),
    "page": ("\n<!DOCTYPE html>\n<html></html>", "page web"),
    "image": (b"\x89PNG\r\n\x1a\n", "image"),
    "wide": (DOUBLE.encode("utf-16"), "UTF-16"),
    "wide, read as UTF-8": (DOUBLE.encode("utf-16").decode("utf-8", "replace"), "UTF-16"),
}


@pytest.mark.parametrize(("source", "said"), FOREIGN.values(), ids=FOREIGN.keys())
def test_what_is_no_program_is_called_what_it_is(sandbox: Sandbox, source: str | bytes, said: str) -> None:
    with pytest.raises(ProgramFault) as caught:
        opened(sandbox, source)
    assert caught.value.kind is FaultKind.SYNTAX_ERROR
    assert said in caught.value.message


@pytest.mark.parametrize("source", [DOUBLE, "", "{}\n", "{1, 2}\n", "# %PDF-1.7\n", "\ufeff" + DOUBLE, "x = '\0'\n"])
def test_what_may_be_a_program_is_none_of_these(source: str) -> None:
    assert describe_foreign_file(source.encode()) in (None, describe_foreign_file(b"{}"))


def test_an_empty_file_is_said_to_be_empty(sandbox: Sandbox) -> None:
    with opened(sandbox, " \n\n") as session, pytest.raises(ProgramFault, match="vide"):
        session.call("f", 1.0)


def test_a_cell_may_be_a_value(sandbox: Sandbox) -> None:
    with opened(sandbox, '{"a": 1}', echo_last=True) as session:
        assert session.stdout() == "{'a': 1}\n"


@pytest.mark.parametrize(
    "reported",
    [
        *(None, (), (("f",),), (("f",), 3), ((1,), ()), (("f" * 500,), ()), (("f",), (("exit", 0),))),
        *((("f",), (("drawing", "évasion"),)), (("f",), (("exit", "<b>"),)), (("f",), (("magic", 1),) * 50)),
        *((("f",), (("magic", 1, 2),)), (("f",), ("magic",)), (("f",) * 2000, ())),
    ],
)
def test_a_report_of_another_form_is_refused(reported: object) -> None:
    assert parse_loaded(reported) is None
