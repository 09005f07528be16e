"""A student's file, loaded and called again and again: what it finds, what it may print, what comes back."""

from __future__ import annotations

import time

import numpy as np
import pytest

from server.sandbox import FaultKind, Kit, ProgramFault, Sandbox, SandboxFault

from .limits import only


def test_calls_are_interactive_and_the_program_keeps_its_state(sandbox: Sandbox) -> None:
    source = b"total = 0\ndef ajouter(x):\n    global total\n    total += x\n    return total\n"
    with sandbox.open(source) as session:
        assert [session.call("ajouter", k).value for k in (1, 2, 3)] == [1, 3, 6]
        assert session.functions == {"ajouter"}


def test_two_executions_share_nothing(sandbox: Sandbox) -> None:
    source = b"import numpy\nseen = hasattr(numpy, 'marque')\nnumpy.marque = 1\ndef f():\n    return seen\n"
    for _ in range(3):
        with sandbox.open(source) as session:
            assert session.call("f").value is False


def test_values_come_back_with_their_exact_types(sandbox: Sandbox) -> None:
    source = b"import numpy as np\ndef f(x):\n    return x, np.float32(0.5), np.eye(2) @ x, {'a': (True, None)}\n"
    with sandbox.open(source) as session:
        given, scalar, product, mapping = session.call("f", np.array([1.0, 2.0])).value  # type: ignore[misc, union-attr]
    assert type(given) is np.ndarray
    assert type(scalar) is float
    assert product.tolist() == [1.0, 2.0]
    assert mapping == {"a": (True, None)}


def test_arguments_come_back_as_they_are_after_the_call(sandbox: Sandbox) -> None:
    source = b"def f(a, b):\n    a[0] = 7\n    b.append(1)\n    return None\n"
    with sandbox.open(source) as session:
        mine = np.zeros(2)
        reply = session.call("f", mine, [0], return_arguments=True)
        assert reply.arguments is not None
        assert reply.arguments[0].tolist() == [7.0, 0.0]  # type: ignore[union-attr]
        assert reply.arguments[1] == [0, 1]
        assert mine.tolist() == [0.0, 0.0]
        assert session.call("f", mine, [0]).arguments is None


def test_the_kit_is_found_without_importing_and_by_importing(sandbox: Sandbox, kit: Kit) -> None:
    source = b"""
import trousse
from trousse import lidar as autre
def f():
    return PORTEE_MAX, [trousse.lidar is lidar is autre, float(rng.uniform())], lidar(np.zeros(3), 2)
"""
    with sandbox.open(source, kit=kit) as session:
        portee, (shared, drawn), scan = session.call("f").value  # type: ignore[misc, union-attr]
        assert session.functions == {"f", "autre"}
    assert (portee, scan.tolist(), shared) == (7.0, [7.0, 7.0], True)
    assert drawn == np.random.default_rng(42).uniform()


def test_a_seed_makes_every_generator_repeat(sandbox: Sandbox, kit: Kit) -> None:
    source = b"import random, numpy\ndef f():\n    return random.random(), numpy.random.rand(), float(rng.random())\n"
    draws = []
    for _ in range(2):
        with sandbox.open(source, kit=kit) as session:
            draws.append(session.call("f").value)
    assert draws[0] == draws[1]


def test_without_a_seed_generators_differ_between_executions(sandbox: Sandbox) -> None:
    source = b"import random, numpy\ndef f():\n    return random.random(), numpy.random.rand()\n"
    draws = []
    for _ in range(2):
        with sandbox.open(source) as session:
            draws.append(session.call("f").value)
    assert draws[0] != draws[1]


@pytest.mark.parametrize(
    "source",
    [
        "def f():\n\treturn 1\n".encode("utf-8-sig"),
        b"def f():\r\n    return 1\r\n",
        b"from __future__ import annotations\ndef f(x: Inconnu = 1) -> Autre:\n    return x\n",
        "# -*- coding: latin-1 -*-\ndef f():\n    return len('é')\n".encode("latin-1"),
        b"def f():\n    return 1\nif __name__ == '__main__':\n    raise SystemExit\n",
        b"from dataclasses import dataclass\n@dataclass\nclass A:\n    x: int = 1\ndef f():\n    return A().x\n",
        b"f = lambda: 1",
        b"import functools\n@functools.lru_cache\ndef f():\n    return 1\n",
        b"import sys\ndef f():\n    return int(__name__ == 'solution' and sys.modules['solution'].f is f)\n",
    ],
    ids=["bom-tabs", "crlf", "future", "latin-1", "main-block", "dataclass", "lambda", "decorator", "module"],
)
def test_files_as_students_write_them(sandbox: Sandbox, source: bytes) -> None:
    with sandbox.open(source) as session:
        assert session.call("f").value == 1


def test_what_is_printed_is_kept_with_warnings_and_undecodable_bytes(sandbox: Sandbox) -> None:
    source = """
import os, sys, warnings
import numpy as np
print("chargé")
def f():
    print("appelé", end="")
    warnings.warn("attention")
    np.array(1.0) / np.array(0.0)
    sys.stderr.write("erreur\\n")
    os.write(1, b"\\xff\\0brut")
    return 1
"""
    with sandbox.open(source.encode()) as session:
        assert session.call("f").value == 1
        assert session.stdout().startswith("chargé\nappelé")
    for piece in ("attention", "divide by zero", "erreur\n", "\ufffd\ufffdbrut"):
        assert piece in session.stdout()
    assert not session.stdout_truncated


def test_output_beyond_its_bound_is_cut_and_no_failure(sandbox: Sandbox) -> None:
    source = "def f():\n    for k in range(200_000):\n        print('é' * 1000)\n    return 1\n".encode()
    with sandbox.open(source) as session:
        assert session.call("f").value == 1
        assert session.stdout_truncated
    printed = session.stdout().encode()
    assert sandbox.policy.stdout_bytes - 2 <= len(printed) <= sandbox.policy.stdout_bytes
    assert "\ufffd" not in session.stdout()


def test_beyond_its_bound_print_formats_nothing_and_still_prints_elsewhere(sandbox: Sandbox) -> None:
    source = """
import contextlib, io, sys
written = []
class Heavy:
    def __str__(self):
        written.append(1)
        return "x" * 1000
def f():
    for k in range(100_000):
        print(Heavy(), k, sep=", ")
        print(Heavy(), file=sys.stdout, flush=True)
    count = len(written)
    text = io.StringIO()
    print("ailleurs", file=text)
    with contextlib.redirect_stdout(text):
        print("capturé", end="!")
    try:
        print(1, nonsense=2)
    except TypeError:
        return (count, text.getvalue(), print.__name__, sys.stdout.write("abc"))
"""
    with sandbox.open(source.encode()) as session:
        count, *others = session.call("f").value
        assert session.stdout_truncated
    assert count <= sandbox.policy.stdout_bytes // 1000 + 2
    assert others == ["ailleurs\ncapturé!", "print", 3]


def test_what_a_killed_program_printed_stays_readable(sandbox: Sandbox) -> None:
    source = b"import os\ndef f():\n    print('avant')\n    os._exit(3)\n"
    with sandbox.open(source) as session:
        with pytest.raises(ProgramFault):
            session.call("f")
        assert session.stdout() == "avant\n"


def test_an_exception_leaves_the_program_alive(sandbox: Sandbox) -> None:
    with sandbox.open(b"def f(x):\n    return 1 / x\n") as session:
        with pytest.raises(ProgramFault) as caught:
            session.call("f", 0)
        assert not caught.value.fatal
        assert session.call("f", 2).value == 0.5


def test_a_dead_program_repeats_its_fault(sandbox: Sandbox) -> None:
    with sandbox.open(b"import os\ndef f():\n    os._exit(0)\n") as session:
        faults = []
        for _ in range(2):
            with pytest.raises(ProgramFault) as caught:
                session.call("f")
            faults.append(caught.value)
        assert faults[0] is faults[1]
        assert faults[0].fatal


def test_usage_is_measured_by_the_kernel(sandbox: Sandbox) -> None:
    source = b"""
import time
def f():
    while time.process_time() < 0.2: pass
    return bytearray(30 << 20) and time.process_time()
"""
    start = time.monotonic()
    with sandbox.open(source) as session:
        told = session.call("f").value
    assert isinstance(told, float)
    assert 0.2 <= told <= session.usage.cpu_seconds + 0.01 < told + 5.0
    assert 0.0 < session.usage.wall_seconds <= time.monotonic() - start
    assert session.usage.max_rss_bytes > 30 << 20
    with pytest.raises(SandboxFault):
        session.call("f")


def test_only_the_time_spent_waiting_for_answers_counts(sandbox: Sandbox) -> None:
    """Told by both clocks: that of the session, and the program's timer, which says what is left of its time."""
    source = b"import signal\ndef left():\n    return signal.getitimer(signal.ITIMER_REAL)[0]\n"
    sandbox.warm()
    start = time.monotonic()
    with sandbox.open(source) as session:
        before = session.call("left").value
        pause = time.monotonic()
        time.sleep(0.2)
        pause = time.monotonic() - pause
        session.call("left")
        after = session.call("left").value
        elapsed = time.monotonic() - start
    assert isinstance(before, float)
    assert isinstance(after, float)
    assert 0.0 < before - after <= elapsed - pause
    assert 0.0 < session.usage.wall_seconds <= elapsed - pause


def test_scipy_is_there_when_the_source_asks_for_it(sandbox: Sandbox) -> None:
    pytest.importorskip("scipy")
    source = (
        b"from scipy.sparse import csr_matrix\nfrom scipy.linalg import inv\ndef f(x):\n    return csr_matrix(inv(x))\n"
    )
    with sandbox.open(source) as session:
        assert np.allclose(session.call("f", 2.0 * np.eye(3)).value, 0.5 * np.eye(3))  # type: ignore[arg-type]


def test_a_policy_of_threads_lets_threads_run(sandbox: Sandbox) -> None:
    source = b"""
import threading
def f():
    seen = []
    thread = threading.Thread(target=seen.append, args=(1,))
    thread.start(); thread.join()
    return seen
"""
    with sandbox.open(source, policy=only(threads=4)) as session:
        assert session.call("f").value == [1]


def test_a_class_of_the_file_is_a_function_to_call(sandbox: Sandbox, kit: Kit) -> None:
    source = b"class Noeud(dict):\n    pass\nimport math\nx = 3\ndef g(): pass\n"
    with sandbox.open(source, kit=kit) as session:
        assert session.functions == {"Noeud", "g"}
        assert session.call("Noeud").value == {}


def test_a_missing_function_is_named_with_its_near_miss(sandbox: Sandbox) -> None:
    with sandbox.open(b"def Compose(a, b):\n    return a\n") as session:
        with pytest.raises(ProgramFault) as caught:
            session.call("composer", 1, 2)
        assert caught.value.kind == FaultKind.MISSING_FUNCTION
        assert not caught.value.fatal
        assert "« composer »".replace(" ", "\u00a0") in caught.value.message
        assert "« Compose »".replace(" ", "\u00a0") in caught.value.message


def test_objects_that_lie_come_back_as_plain_values(sandbox: Sandbox) -> None:
    """Whatever their operators say, the trusted side compares base types only."""
    source = b"""
import numpy as np
class Egal(np.ndarray):
    __eq__ = __le__ = __lt__ = lambda self, autre: np.True_
    def __array_ufunc__(self, *a, **k): return np.zeros(3)
    def __array_finalize__(self, objet): pass
class Flottant(float):
    __eq__ = lambda self, autre: True
    __sub__ = __rsub__ = lambda self, autre: 0.0
    __hash__ = float.__hash__
class Texte(str):
    __eq__ = lambda self, autre: True
    __hash__ = str.__hash__
class Liste(list):
    __len__ = lambda self: 3
    __iter__ = lambda self: iter([0.0, 0.0, 0.0])
class Muet:
    def __array__(self, dtype=None, copy=None): return np.arange(3.0).view(Egal)
def f():
    return np.arange(3.0).view(Egal), Flottant(9.0), Texte("non"), Liste([7]), Muet(), {Texte("cle"): Flottant(1.0)}
"""
    with sandbox.open(source) as session:
        array, number, text, items, muted, mapping = session.call("f").value  # type: ignore[misc]
    assert [type(value) for value in (array, muted)] == [np.ndarray, np.ndarray]
    assert array.tolist() == muted.tolist() == [0.0, 1.0, 2.0]
    assert (type(number), type(text), type(items)) == (float, str, list)
    assert (number, text, items, mapping) == (9.0, "non", [7], {"cle": 1.0})
    assert not np.array_equal(array, np.zeros(3))
