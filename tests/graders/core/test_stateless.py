"""Programs whose text shows that they remember nothing, and those of which it leaves a doubt."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from graders.core.code.stateless import is_stateless, may_keep_state
from graders.core.contract.local import LOCAL
from graders.core.contract.program import StudentFault
from graders.l20 import world
from tests.support.shipped import CODE
from tests.support.tables import folded

KIT = {"np": np, "rng": np.random.default_rng(0), "libres": np.ones((3, 3), dtype=bool)}

STEADY = [
    "def f(x):\n    return x + 1\n",
    '"""Un texte."""\nimport numpy as np\nimport math\nfrom math import cos, pi\nG = -9.81\nDEUX = (0.5, 2)\n',
    "import numpy\nTOUR = 2 * numpy.pi\ndef f(x):\n    return numpy.array([x % TOUR, *x])\n",
    "def f(x):\n    total = 0\n    for i, v in enumerate(x):\n        total += v * i\n    return total\n",
    "def f(x):\n    y = np.zeros(3)\n    y[0] = x[1]\n    y[1:] += 2\n    return y\n",
    "def f(x, k=2):\n    def g(y):\n        return y * k\n    return [g(v) for v in x if v is not None]\n",
    "def f(x):\n    x.sort()\n    x[0] = 7\n    return x\n",
    "def f(x):\n    if x.shape != (3,):\n        raise ValueError('forme')\n    return max(x, key=lambda v: -v)\n",
    "def f(n):\n    return 1 if n < 2 else n * f(n - 1)\n",
    "def f(x: float) -> float:\n    y: float = np.linalg.norm(x, axis=0)\n    return y\n",
]
#: Each keeps, draws or asks something, or might.
DOUBTFUL = [
    "n = 0\ndef f(x):\n    global n\n    n += 1\n    return n\n",
    "seen = []\ndef f(x):\n    seen.append(x)\n    return len(seen)\n",
    "def f(x, seen=[]):\n    seen.append(x)\n    return len(seen)\n",
    "def f(x, *, seen=[]):\n    return seen\n",
    "def f(x):\n    f.n = 1\n    return x\n",
    "def g():\n    n = 0\n    def f(x):\n        nonlocal n\n        n += 1\n        return n\n    return f\nf = g()\n",
    "f = make()\n",
    "from functools import cache\n@cache\ndef f(x):\n    return x\n",
    "def f(x):\n    return np.random.rand()\n",
    "def f(x):\n    return rng.random() + x\n",
    "def f(x):\n    return libres.sum()\n",
    "def f(libres):\n    return libres\n",
    "def f(x):\n    np.pi = 3\n    return x\n",
    "def f(x):\n    np.seterr(all='ignore')\n    return x\n",
    "def f(x):\n    return np.empty(3)\n",
    "def f(x):\n    return np.sqrt(x, where=x > 0)\n",
    "def f(x):\n    return np.sqrt(x, **{'where': x > 0})\n",
    "def f(x):\n    x.base[0] = 1\n    return x\n",
    "def f(x):\n    print(x)\n    return x\n",
    "def f(x):\n    return id(x)\n",
    "def f(x):\n    return x is x\n",
    "def f(x):\n    return [open for open in x] and open('/tmp/n', 'a')\n",
    "def open(x):\n    return x\n",
    "def f(x):\n    return globals()\n",
    "def f(x):\n    return __name__\n",
    "def f(__builtins__):\n    return 1\n",
    "def f(x):\n    return x.__class__\n",
    "def f(x):\n    return {v for v in x}\n",
    "def f(x):\n    try:\n        return x[0]\n    except Exception:\n        return 0\n",
    "def f(x):\n    with open('n') as n:\n        return n\n",
    "def f(x):\n    import time\n    return time.time()\n",
    "import time\ndef f(x):\n    return x\n",
    "from numpy.random import rand\ndef f(x):\n    return x\n",
    "from numpy import *\ndef f(x):\n    return x\n",
    "from mes_fonctions import g\ndef f(x):\n    return g(x)\n",
    "class A:\n    n = 0\ndef f(x):\n    return x\n",
    "f = lambda x: x\n",
    "def f(x):\n    yield x\n",
    "async def f(x):\n    return x\n",
    "for k in range(3):\n    pass\n",
    "np = 3\nnp.x = 4\n",
    "def f(x:\n    return x\n",
    "def f(x):\n    return " + "(" * 300 + "x" + ")" * 300 + "\n",
    "# " + "x" * 20_000 + "\ndef f(x):\n    return x\n",
]


@pytest.mark.parametrize("source", STEADY)
def test_what_can_keep_nothing_is_seen_to_remember_nothing(source: str) -> None:
    assert is_stateless(source.encode(), KIT)


@folded("source", DOUBTFUL)
def test_what_leaves_a_doubt_is_believed_to_remember(source: str) -> None:
    assert not is_stateless(source.encode(), KIT)


def test_what_a_kit_gives_beside_numpy_and_math_may_be_anything() -> None:
    assert is_stateless(b"def f(x):\n    return x\n", {"np": np, "math": math})
    assert not is_stateless(b"def f(x):\n    return x\n", {"np": np, "__drivers__": {}})
    assert not is_stateless(b"def f(x):\n    return np.sin(x)\n", {"np": math, "sin": 3, "math": np} | {"np": object()})
    assert not is_stateless(b"def f(x):\n    return sum(x)\n", {"sum": object()})


def test_a_solution_that_is_seen_to_remember_nothing_answers_the_same_in_whatever_order_it_is_asked() -> None:
    """Of each exercise where it is: the probes of all its functions, shuffled, after one another."""
    seen = 0
    for exercise in ("l20/poses", "l20/odometrie", "l19/gain"):
        grader = CODE[exercise]
        assert grader.prober is not None
        kit = grader.prober.probes[0].kit
        source = grader.solution.encode()
        if not grader.prober.may_probe_without_relaunch(source, kit):
            continue
        calls = [(probes.function, args) for probes in grader.prober.probes for args in probes.calls]
        told = dict(enumerate(_answers(source, calls)))
        order = list(told)
        random.Random(3).shuffle(order)
        again = _answers(source, [calls[place] for place in order])
        assert [repr(told[place]) for place in order] == list(map(repr, again))
        seen += 1
    assert seen


def _answers(source: bytes, calls: list[tuple[str, tuple[object, ...]]]) -> list[object]:
    program, told = LOCAL.open(source, world.STILL), []
    for function, args in calls:
        try:
            told.append(program.call(function, *args).value)
        except StudentFault as fault:
            told.append(fault.exception)
    return told


@pytest.mark.parametrize(
    ("source", "keeps"),
    [
        ("seen = []\ndef f(x):\n    return x\n", False),
        ("seen = []\ndef f(x):\n    seen.append(x)\n    return x\n", True),
        ("seen: dict = {}\ndef f(x):\n    seen[x] = x\n    return x\n", True),
        ("a = []\nb = a\ndef f(x):\n    b.append(x)\n    return x\n", True),
        ("a = b = []\ndef f(x):\n    b.append(x)\n    return x\n", True),
        ("def f(x, seen=[]):\n    return x\n", True),
        ("def f(x):\n    return x\nf.seen = {}\n", True),
        ("class C:\n    seen = []\n    def f(self, x):\n        return x\n", True),
        ("class C:\n    count = 0\n    def f(self, x):\n        C.count += 1\n        return x\n", True),
        ("class C:\n    least = 0\n    def f(self, x):\n        self.x = x\n        return x\n", False),
    ],
)
def test_a_value_that_nobody_reads_keeps_nothing(source: str, keeps: bool) -> None:
    """Where something is kept, a launch more asks in reverse order."""
    assert may_keep_state(source.encode()) == keeps
