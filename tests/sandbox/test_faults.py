"""Every way in which a student's program can fail has its kind, its line, and a French message that helps."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable

import numpy as np
import pytest

from server.sandbox import FaultKind, Policy, ProgramFault, Sandbox, messages
from server.sandbox.diagnosis import parse_last_frames

from .limits import only

FaultOf = Callable[..., ProgramFault]


def plain(text: str) -> str:
    return text.replace("\u00a0", " ")


@pytest.mark.parametrize(
    ("count", "told"),
    [(12, "12 octets"), (64 << 10, "64 Kio"), (1536 << 10, "1,5 Mio"), (1000 << 20, "1000 Mio"), (4 << 30, "4 Gio")],
)
def test_limits_are_told_in_units_that_people_read(count: int, told: str) -> None:
    assert messages.format_byte_size(count) == told


def test_many_values_are_told_with_the_space_of_thousands() -> None:
    assert "10\u202f000 valeurs" in messages.answer_too_big("items", "f", Policy())
    assert "100\u202f000 valeurs" in messages.answers_too_big("items", Policy())


@pytest.mark.parametrize(
    ("source", "line", "told"),
    [
        ("def f(x)\n    return x\n", 1, "il manque « : » à la fin"),
        ("def f(x):\n    return (x\n", 2, "« ( » est ouvert ici"),
        ("def f(x):\n    return x)\n", 2, "« ) » ferme ce qui n’a pas été ouvert"),
        ("def f(x):\nreturn x\n", 2, "la ligne 1 doit être décalé à droite"),
        ("x = 1\n   y = 2\n", 2, "décalée vers la droite sans raison"),
        ("def f(x):\n    if x = 1:\n        pass\n", 2, "pour comparer, écrivez « == »"),
        ("x = 'abc\n", 1, "il manque le guillemet"),
        ("x = 1\ny = “a”\n", 2, "copier-coller"),
        ("x = 1\nprint 'a'\n", 2, "« print » est une fonction"),
        ("x = '\u2028'\n\x0c\nreturn 3\n", 3, "Ligne lue : return 3"),
        ("x = 1\0\n", 1, "octet nul"),
        (b"# ok\nx = '\xe9'\n", 2, "UTF-8"),
        ("x = " + "(" * 300 + ")" * 300, 1, "imbriqu"),
        ("x = " + "-" * 20_000 + "1", None, "mémoire|imbriqu"),
    ],
)
def test_a_file_that_is_not_python(fault_of: FaultOf, source: str | bytes, line: int | None, told: str) -> None:
    fault = fault_of(source)
    assert fault.kind in (FaultKind.SYNTAX_ERROR, FaultKind.MEMORY_LIMIT, FaultKind.RUNTIME_ERROR)
    assert (fault.kind == FaultKind.SYNTAX_ERROR) == ("|" not in told)
    assert any(piece in plain(fault.message) for piece in told.split("|")), fault.message
    assert fault.line == line


def test_a_syntax_error_quotes_its_line(fault_of: FaultOf) -> None:
    fault = fault_of("x = 1\ndef composer(a, b)\n    return a\n")
    assert "def composer(a, b)" in fault.message
    assert fault.line == 2


def test_a_file_beyond_its_bound_is_refused_with_the_bound(fault_of: FaultOf) -> None:
    fault = fault_of("# " + "x" * 70_000)
    assert fault.kind == FaultKind.SYNTAX_ERROR
    assert "64 Kio" in plain(fault.message)


@pytest.mark.parametrize(
    ("source", "told"),
    [
        ("import nunpy as np", "« numpy »"),
        ("import pandas", "« pandas » n’est pas disponible"),
        ("from math import racine", "Le module « math » n’a pas de « racine » : écrivez np.sqrt"),
        ("import graders", "n’est pas disponible"),
        ("import server.sandbox", "n’est pas disponible"),
        ("import child.codec", "n’est pas disponible"),
    ],
)
def test_an_import_that_fails(fault_of: FaultOf, source: str, told: str) -> None:
    fault = fault_of("# un commentaire\n" + source + "\n")
    assert (fault.kind, fault.line) == (FaultKind.IMPORT_ERROR, 2)
    assert told in plain(fault.message)


def test_a_traceback_has_the_students_own_frames_only(fault_of: FaultOf) -> None:
    source = (
        "import numpy as np\n\ndef g(a):\n    return np.linalg.inv(a)\n\ndef f(x):\n    return g(np.zeros((2, 2)))\n"
    )
    fault = fault_of(source, 1)
    assert (fault.kind, fault.exception, fault.line) == (FaultKind.RUNTIME_ERROR, "LinAlgError", 4)
    assert [(frame.line, frame.function, frame.source) for frame in fault.frames] == [
        (7, "f", "return g(np.zeros((2, 2)))"),
        (4, "g", "return np.linalg.inv(a)"),
    ]
    assert "singulière" in fault.message


@pytest.mark.parametrize(
    ("body", "exception", "told"),
    [
        ("return inconnu", "NameError", "n’est défini nulle part"),
        ("return [1][3]", "IndexError", "de 0 à la longueur moins un"),
        ("return f(x)", "RecursionError", "s’appelle elle-même sans fin"),
        ("import sys; sys.exit(2)", "SystemExit", "utilisez « return »"),
        ("return exit()", "SystemExit", "utilisez « return »"),
        ("return input()", "EOFError", "Rien ne peut être lu au clavier"),
        ("return open('donnees.txt')", "FileNotFoundError", "arrive par les arguments"),
        ("raise KeyboardInterrupt", "KeyboardInterrupt", "KeyboardInterrupt"),
        ("return np.ones(2) @ np.ones(3)", "ValueError", "dimensions"),
        ("return eval('1 +')", "SyntaxError", "SyntaxError"),
    ],
)
def test_an_exception_is_explained(fault_of: FaultOf, body: str, exception: str, told: str) -> None:
    fault = fault_of(f"import numpy as np\ndef f(x):\n    {body}\n", 1)
    assert (fault.kind, fault.exception, fault.line) == (FaultKind.RUNTIME_ERROR, exception, 3)
    assert told in plain(fault.message)
    assert not fault.fatal


def test_the_sentences_have_the_apostrophes_of_print() -> None:
    """Cells show them as they are."""
    assert re.findall(r"\b(?:[cdjlmnst]|qu)'\w+", inspect.getsource(messages), re.IGNORECASE) == []


@pytest.mark.parametrize(
    "definition",
    [
        "class E(Exception):\n    def __str__(self): raise ValueError\n    __repr__ = __str__",
        "class E(Exception):\n    def __str__(self): return 'x' * 10**7",
        "class E(BaseException):\n    def __str__(self): return 3",
        "E = type('E' * 10**6, (Exception,), {})",
        "class E(Exception):\n    def __str__(self): return '\\x1b[31m\\u202erouge\\0'",
        "class E(Exception):\n    __traceback__ = property(lambda self: 1 / 0)",
        "class E(OSError):\n    errno = property(lambda self: 1 / 0)",
    ],
)
def test_an_odd_exception_changes_nothing(fault_of: FaultOf, definition: str) -> None:
    fault = fault_of(f"{definition}\ndef f(x):\n    raise E()\n", 1)
    assert fault.kind in (FaultKind.RUNTIME_ERROR, FaultKind.INVALID_OUTPUT)
    assert len(fault.message) < 2000
    assert all(character.isprintable() or character in "\n\u00a0" for character in fault.message)


def test_the_limits_are_told(fault_of: FaultOf) -> None:
    told = {
        "return bytearray(1 << 40)": (FaultKind.MEMORY_LIMIT, "64 Mio"),
        "return 'x' * 300_000": (FaultKind.OUTPUT_LIMIT, "256 Kio"),
        "return list(range(5000))": (FaultKind.OUTPUT_LIMIT, "1\u202f000 valeurs"),
    }
    policy = only(memory_bytes=64 << 20, frame_bytes=1 << 18, items=1000)
    for body, (kind, limit) in told.items():
        fault = fault_of(f"\ndef f(x):\n    {body}\n", 1, policy=policy)
        assert fault.kind == kind
        assert limit in plain(fault.message)
        assert fault.line in (3, None)


def test_a_program_stuck_in_one_call_is_told_where_too(fault_of: FaultOf) -> None:
    source = "def f():\n    return réfléchir()\n\ndef réfléchir():\n    return sum(range(10**14))\n"
    fault = fault_of(source, policy=only(cpu_seconds=0.2))
    assert fault.kind == "timeout"
    assert [(frame.line, frame.function) for frame in fault.frames] == [(2, "f"), (5, "réfléchir")]
    assert "Ligne 5, dans « réfléchir » (return sum(range(10**14)))" in plain(fault.message)


@pytest.mark.parametrize(
    "words",
    [
        "",
        "n'importe quoi",
        '  File "solution.py", line 3 in f\n',
        '  File "solution.py", line 0 in f\n  File "autre.py", line 1 in f\n',
        '  File "solution.py", line 9999999999999999999 in f\n',
        f'  File "solution.py", line 1 in {"f" * 5000}\n',
    ],
)
def test_last_words_that_tell_nothing_are_not_believed(words: str) -> None:
    assert parse_last_frames(words, "solution.py", ["def f():", "    pass"]) == ()


def test_last_words_are_cleaned_and_bounded() -> None:
    words = '  File "solution.py", line 1 in <b>\\x1b\\u202e\n' * 100
    frames = parse_last_frames(words, "solution.py", ["x = 1"])
    assert 0 < len(frames) < 20
    assert {frame.function for frame in frames} == {"<b>\ufffd\ufffd"}


def test_a_program_that_is_too_long_is_told_where_it_was(fault_of: FaultOf) -> None:
    told = {
        "while True: pass": ("0,3 s", only(cpu_seconds=0.3)),
        "import time; time.sleep(3600)": ("1 s", only(wall_seconds=1.0)),
    }
    for body, (limit, policy) in told.items():
        fault = fault_of(f"\ndef f(x):\n    {body}\n", 1, policy=policy)
        assert (fault.kind, fault.line, fault.fatal) == (FaultKind.TIMEOUT, 3, True)
        assert limit in plain(fault.message)
        assert ("calculé" in fault.message) == ("while" in body)


LINELESS = """
def f(x):
    while True:
        pass
f.__code__ = f.__code__.replace(co_linetable=b"")
"""


def test_a_program_caught_where_it_has_no_line_is_told_where_it_begins(fault_of: FaultOf) -> None:
    """At the entry of a function the interpreter may know no line yet (here, nowhere): that was told as cheating."""
    fault = fault_of(LINELESS, 1, policy=only(cpu_seconds=0.05))
    assert (fault.kind, fault.line) == (FaultKind.TIMEOUT, 2)
    assert [(frame.line, frame.function, frame.source) for frame in fault.frames] == [(2, "f", "def f(x):")]


def test_an_exception_where_there_is_no_line_is_told_where_its_function_begins(fault_of: FaultOf) -> None:
    fault = fault_of(LINELESS.replace("while True:\n        pass", "return x / 0"), 1)
    assert (fault.kind, fault.exception, fault.line) == (FaultKind.RUNTIME_ERROR, "ZeroDivisionError", 2)


@pytest.mark.parametrize(
    ("result", "told"),
    [
        ("(k for k in range(3))", "generator"),
        ("{1, 2}", "sorted"),
        ("[1, {2: 3}]", "clé"),
        ("f", "parenthèses de l’appel"),
        ("np.array([[1, 2], [3]], dtype=object)", "même longueur"),
        ("np.array(['a'])", "tableau d’éléments"),
        ("b'octets'", "bytes"),
        ("boucle", "se contient-il lui-même"),
    ],
)
def test_a_result_that_is_no_value_is_named(fault_of: FaultOf, result: str, told: str) -> None:
    fault = fault_of(f"import numpy as np\nboucle = []\nboucle.append(boucle)\ndef f(x):\n    return {result}\n", 1)
    assert fault.kind == FaultKind.INVALID_OUTPUT
    assert told in plain(fault.message)
    assert not fault.fatal


def test_a_lack_of_memory_leaves_the_program_able_to_answer(sandbox: Sandbox) -> None:
    source = b"import numpy as np\ndef f(n):\n    held = [np.ones(1000) for k in range(n)]\n    return len(held)\n"
    with sandbox.open(source) as session:
        for _ in range(2):
            with pytest.raises(ProgramFault) as caught:
                session.call("f", 10**7)
            assert caught.value.kind == FaultKind.MEMORY_LIMIT
        assert session.call("f", 10).value == 10


def test_the_code_of_the_top_level_may_fail_too(fault_of: FaultOf) -> None:
    fault = fault_of("x = 1\ny = x / 0\n")
    assert (fault.kind, fault.line, fault.frames[-1].function) == (FaultKind.RUNTIME_ERROR, 2, "<module>")


def test_deep_recursion_ends_in_a_recursion_error_even_when_the_limit_is_raised(fault_of: FaultOf) -> None:
    for definition in (
        "def f(x):\n    return f(x) + 1",
        "class A:\n    def __repr__(self): return repr(self)\nf = lambda x: repr(A())",
    ):
        fault = fault_of(f"import sys\nsys.setrecursionlimit(10**9)\n{definition}\n", 1)
        assert (fault.kind, fault.exception) == (FaultKind.RUNTIME_ERROR, "RecursionError")
        assert len(fault.frames) <= 8


def test_an_array_given_in_is_an_array_of_the_students_own(sandbox: Sandbox) -> None:
    with sandbox.open(b"def f(x):\n    x += 1\n    return x\n") as session:
        given = np.zeros(3)
        assert session.call("f", given).value.tolist() == [1.0, 1.0, 1.0]  # type: ignore[union-attr]
        assert given.tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("body", "exception", "told"),
    [
        ("return [open('/dev/null') for _ in range(10_000)]", "OSError", "fermez-les"),
        ("raise OSError(28, 'No space left on device', '/home/eleve/a')", "OSError", "dossier est plein"),
        ("raise OSError(27, 'File too large')", "OSError", "fichier est trop gros"),
        ("return str(10**10_000)", "ValueError", "4300"),
        ("return np.exp(1000) / 0.0 if False else 2.0**5000", "OverflowError", "trop grand"),
        ("return next(iter(()))", "StopIteration", "épuisé"),
    ],
)
def test_a_limit_of_the_system_is_told_as_what_it_is(fault_of: FaultOf, body: str, exception: str, told: str) -> None:
    fault = fault_of(f"import numpy as np\ndef f(x):\n    {body}\n", 1)
    assert (fault.kind, fault.exception, fault.line) == (FaultKind.RUNTIME_ERROR, exception, 3)
    assert told in plain(fault.message), fault.message


@pytest.mark.parametrize(
    "body",
    ["import socket; socket.gethostbyname('exemple.fr')", "import os; os.setsid()", "open('/etc/passwd')"],
)
def test_what_is_out_of_reach_is_forbidden(fault_of: FaultOf, body: str) -> None:
    fault = fault_of(f"\ndef f(x):\n    {body}\n", 1)
    assert (fault.kind, fault.line) == (FaultKind.FORBIDDEN_OPERATION, 3)
    assert "hors d’atteinte" in fault.message


def test_names_are_told_without_what_they_hide(sandbox: Sandbox) -> None:
    source = b"globals()['comp\\x1b[2J\\u202eoser'] = lambda a: a\n"
    with sandbox.open(source) as session, pytest.raises(ProgramFault) as caught:
        session.call("composer")
    assert "comp\ufffd[2J\ufffdoser" in caught.value.message


@pytest.mark.parametrize(
    ("body", "limit", "told"),
    [
        ("np.zeros(3000)", {"session_bytes": 1 << 16}, "64 Kio"),
        ("'é' * 9000", {"session_bytes": 1 << 16}, "64 Kio"),
        ("[1] * 900", {"session_items": 3000, "items": 1000}, "3\u202f000 valeurs"),
        ("{str(k): 1 for k in range(400)}", {"session_items": 3000, "items": 1000}, "3\u202f000 valeurs"),
        ("[[]] * 900", {"session_items": 3000, "items": 1000}, "3\u202f000 valeurs"),
    ],
)
def test_answers_that_are_too_big_together_end_the_session(
    sandbox: Sandbox, body: str, limit: dict[str, int], told: str
) -> None:
    source = f"import numpy as np\ndef f():\n    return {body}\ndef g():\n    return 1\n".encode()
    with sandbox.open(source, policy=only(**limit)) as session:
        answers = list(session.call_many("f", [()] * 20))
        fault = answers.pop()
        assert isinstance(fault, ProgramFault)
        assert (fault.kind, fault.fatal) == (FaultKind.OUTPUT_LIMIT, True)
        assert told in plain(fault.message)
        assert 2 <= len(answers) <= 8
        assert not any(isinstance(answer, ProgramFault) for answer in answers)
        with pytest.raises(ProgramFault, match="en tout"):
            session.call("g")


def test_a_program_may_answer_up_to_its_limit(sandbox: Sandbox) -> None:
    policy = only(session_items=1000 + 10 * 903, items=1000)
    with sandbox.open(b"def f():\n    return [1] * 900\n", policy=policy) as session:
        assert all(not isinstance(answer, ProgramFault) for answer in session.call_many("f", [()] * 10))
