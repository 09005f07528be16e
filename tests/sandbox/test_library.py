"""Functions of earlier files: imported from `mes_fonctions`, one's own or those that are not to be read."""

import pytest

from server.sandbox import FaultKind, Kit, LibraryFile, ProgramFault, Sandbox

DOUBLE = LibraryFile("doubles", ("double",), b"def double(x):\n    return PAS * x\n")
SECRET = LibraryFile(
    "secrets", ("triple",), b'def triple(x):\n    """Rien de ceci ne se lit."""\n    # secret\n    return 3 * x\n', True
)
ABOVE = LibraryFile(
    "dessus", ("six",), b"from mes_fonctions import double, triple\ndef six(x):\n    return double(triple(x))\n"
)


def answer(sandbox: Sandbox, source: str, *shelves: LibraryFile) -> object:
    with sandbox.open(source.encode(), kit=Kit("pas", library=shelves)) as session:
        return session.call("f").value


@pytest.mark.parametrize(
    ("beginning", "expression"),
    [
        ("from mes_fonctions import double, six", "[double(1), six(1)]"),
        ("import mes_fonctions", "[mes_fonctions.double(1), mes_fonctions.six(1)]"),
        ("from mes_fonctions import *", "[double(1), six(1)]"),
        ("import mes_fonctions as mf\ndouble = mf.double", "[double(1), mf.six(1)]"),
    ],
)
def test_functions_are_imported_as_from_any_module(sandbox: Sandbox, beginning: str, expression: str) -> None:
    source = f"{beginning}\ndef f():\n    return {expression}\n"
    assert answer(sandbox, source, DOUBLE, SECRET, ABOVE) == [2, 6]


def test_nothing_is_run_that_is_not_asked_for(sandbox: Sandbox) -> None:
    broken = LibraryFile("casse", ("rien",), b"print('lu')\n1 / 0\n")
    source = "from mes_fonctions import double\ndef f():\n    return double(4)\n"
    assert answer(sandbox, source, broken, DOUBLE) == 8


def test_the_text_of_what_is_not_to_be_read_is_nowhere(sandbox: Sandbox) -> None:
    source = """
import gc, mes_fonctions
from mes_fonctions import triple
def f():
    held = [o for o in gc.get_objects() if isinstance(o, (str, bytes))]
    held += [triple.__doc__ or "", *map(str, triple.__code__.co_consts)]
    held += [v for o in gc.get_objects() if isinstance(o, (dict, list, tuple)) for v in
             (o.values() if isinstance(o, dict) else o) if isinstance(v, (str, bytes))]
    wanted = "".join(["Rien de ", "ceci"])
    return [any((wanted.encode() if isinstance(t, bytes) else wanted) in t for t in held), triple(2)]
"""
    assert answer(sandbox, source, SECRET) == [False, 6]


@pytest.mark.parametrize(
    ("source", "kind", "said"),
    [
        ("from mes_fonctions import absente", FaultKind.IMPORT_ERROR, "absente"),
        ("x = 1\nfrom mes_fonctions import rien", FaultKind.RUNTIME_ERROR, "ligne 2"),
        ("from mes_fonctions import tourne", FaultKind.IMPORT_ERROR, "tourne"),
    ],
)
def test_what_goes_wrong_is_told_at_its_line(sandbox: Sandbox, source: str, kind: FaultKind, said: str) -> None:
    broken = LibraryFile("casse", ("rien",), b"1 / 0\n")
    round_and_round = LibraryFile("ronde", ("tourne",), b"from mes_fonctions import tourne\n")
    with pytest.raises(ProgramFault) as caught:
        answer(sandbox, source, broken, round_and_round)
    assert caught.value.kind is kind
    assert said in caught.value.message or caught.value.line == 2


def test_a_file_that_wants_scipy_brings_it_along(sandbox: Sandbox) -> None:
    shelf = LibraryFile(
        "rotations", ("tourne",), b"from scipy.linalg import expm\ndef tourne(x):\n    return expm(0 * x)\n"
    )
    source = "from mes_fonctions import tourne\ndef f():\n    return tourne(np.eye(1)).tolist()\nimport numpy as np\n"
    assert answer(sandbox, source, shelf) == [[1.0]]


def test_there_is_no_such_module_where_nothing_is_reused(sandbox: Sandbox) -> None:
    with pytest.raises(ProgramFault) as caught:
        answer(sandbox, "import mes_fonctions")
    assert caught.value.kind is FaultKind.IMPORT_ERROR
