"""Functions of the course: a program has them called, and has nothing of them in its own process."""

from collections.abc import Iterator
from dataclasses import replace

import pytest

from server.sandbox import FaultKind, Kit, LibraryFile, Policy, ProgramFault, Sandbox, SandboxFault
from server.sandbox import course_process as processes

KIT = """
import numpy as np
def configurer(seed=None, pas=2):
    return {"PAS": pas, "np": np, "rng": np.random.default_rng(seed)}
"""
COURSE = b"""
SECRET = "quetzal"
class Refus(Exception):
    pass
def triple(x):
    quetzal_local = 3 * x
    if isinstance(quetzal_local, str):
        raise ValueError(f"pas un nombre, {x}")
    return quetzal_local
def norme(u, echelle=1.0):
    quetzal_carre = np.square(u)
    return np.sqrt(np.sum(quetzal_carre)) * echelle
def moyenne(liste):
    return sum(liste) / len(liste)
def entree(table):
    return table["absente"]
def singuliere(a):
    return np.linalg.inv(a)
def refuse(x):
    raise Refus("refus du cours")
def tirage():
    return rng.random()
def sans_fin():
    while True:
        pass
def gourmande(n):
    return np.ones(int(n)).sum()
def interne(x):
    from mes_fonctions import cachee
    return cachee(x)
"""
NAMES = ("triple", "norme", "moyenne", "entree", "singuliere", "refuse", "tirage", "sans_fin", "gourmande", "interne")
SEALED = LibraryFile("cours", NAMES, COURSE, sealed=True)
WITHHELD = LibraryFile("autre", ("cachee",), b"def cachee(x):\n    return -x\n", sealed=True, offered=False)
OWN = LibraryFile(
    "mien", ("quadruple",), b"from mes_fonctions import triple\ndef quadruple(x):\n    return triple(x) + x\n"
)
SOON = Policy(cpu_seconds=0.2, wall_seconds=3.0, memory_bytes=128 << 20)


@pytest.fixture(scope="module")
def sandbox() -> Iterator[Sandbox]:
    with Sandbox({"trousse": KIT}) as sandbox:
        yield sandbox


def answer(sandbox: Sandbox, source: str, policy: Policy | None = None) -> object:
    kit = Kit("trousse", {"seed": 4}, library=(SEALED, WITHHELD, OWN))
    with sandbox.open(source.encode(), kit=kit, policy=policy) as session:
        return session.call("f").value


def fault(sandbox: Sandbox, source: str, policy: Policy | None = None) -> ProgramFault:
    with pytest.raises(ProgramFault) as caught:
        answer(sandbox, source, policy)
    return caught.value


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("triple(2)", 6),
        ("triple(x=2)", 6),
        ("norme(np.array([3.0, 4.0]), echelle=2.0)", 10.0),
        ("norme(np.matrix([3, 4])).dtype.name", "float64"),
        ("moyenne({1, 2, 3})", 2.0),
        ("moyenne(range(1, 4))", 2.0),
        ("moyenne(x for x in (1, 2, 3))", 2.0),
        ("quadruple(5)", 20),
        ("interne(7)", -7),
        ("triple(np.ones(2)).tolist()", [3.0, 3.0]),
        ("triple(np.ones((2, 2), dtype=np.float32)).dtype.name", "float32"),
        ("[triple.__name__, callable(triple)]", ["triple", True]),
    ],
)
def test_a_call_gives_the_value_of_the_function(sandbox: Sandbox, expression: str, value: object) -> None:
    assert answer(sandbox, f"from mes_fonctions import *\ndef f():\n    return {expression}\n") == value


@pytest.mark.parametrize(
    ("call", "exception", "text"),
    [
        ("triple()", "TypeError", "Il manque à l’appel de triple\u00a0: x"),
        ("triple('a')", "ValueError", "pas un nombre, a"),
        ("entree({'a': 1})", "KeyError", "'absente'"),
        ("singuliere(np.zeros((2, 2)))", "LinAlgError", "La matrice est singulière"),
        ("refuse(1)", "Refus", "refus du cours"),
        ("triple(lambda: 0)", "TypeError", "ne prend pas une fonction"),
        ("triple(object())", "TypeError", "ne prend pas un objet de type"),
    ],
)
def test_a_bad_argument_is_the_programs_exception_at_its_line(
    sandbox: Sandbox, call: str, exception: str, text: str
) -> None:
    caught = fault(sandbox, f"from mes_fonctions import *\ndef f():\n    return {call}\n")
    assert (caught.kind, caught.exception, caught.line) == (FaultKind.RUNTIME_ERROR, exception, 3)
    assert caught.message.startswith(f"Ligne 3, dans «\u00a0f\u00a0» (return {call})\u00a0: ")
    assert exception in caught.message
    assert text in caught.message
    assert [frame.function for frame in caught.frames] == ["f"]


def test_what_is_drawn_at_random_there_is_not_what_is_drawn_here(sandbox: Sandbox) -> None:
    source = "from mes_fonctions import tirage\ndef f():\n    return [tirage(), float(rng.random())]\n"
    first, again = answer(sandbox, source), answer(sandbox, source)
    assert isinstance(first, list)
    assert first == again
    assert first[0] != first[1]


@pytest.mark.parametrize(
    ("call", "kind"), [("sans_fin()", FaultKind.TIMEOUT), ("gourmande(1e9)", FaultKind.MEMORY_LIMIT)]
)
def test_the_limits_of_the_exercise_hold_there_too(sandbox: Sandbox, call: str, kind: FaultKind) -> None:
    caught = fault(sandbox, f"from mes_fonctions import *\ndef f():\n    return {call}\n", SOON)
    assert (caught.kind, caught.line) == (kind, 3)


def test_calls_are_counted(sandbox: Sandbox, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "MAX_CALLS", 5)
    caught = fault(sandbox, "from mes_fonctions import triple\ndef f():\n    return [triple(k) for k in range(6)]\n")
    assert caught.exception == "RuntimeError"


def test_waiting_for_the_course_costs_a_program_none_of_its_own_time(sandbox: Sandbox) -> None:
    """Its clock of the wall stands still: 0.3 s there and 0.3 s here are within 0.5 s."""
    slow = LibraryFile("lent", ("dort",), b"import time\ndef dort():\n    time.sleep(0.3)\n    return 1\n", sealed=True)
    source = "import time\nfrom mes_fonctions import dort\ndef f():\n    time.sleep(0.3)\n    return dort()\n"
    kit = Kit("trousse", {"seed": 4}, library=(slow,))
    with sandbox.open(source.encode(), kit=kit, policy=replace(SOON, wall_seconds=0.5)) as session:
        assert session.call("f").value == 1


@pytest.mark.parametrize("broken", [b"1 / 0\n", b"def autre():\n    pass\n", b"def rien(:\n"])
def test_a_file_of_the_course_that_fails_is_our_fault(sandbox: Sandbox, broken: bytes) -> None:
    kit = Kit("trousse", {"seed": 4}, library=(LibraryFile("casse", ("rien",), broken, sealed=True),))
    source = b"""
from mes_fonctions import rien
def f():
    try:
        return rien()
    except BaseException:
        return 0
"""
    with sandbox.open(source, kit=kit) as session, pytest.raises(SandboxFault):
        session.call("f")


def test_a_process_of_the_course_that_is_killed_is_our_fault(sandbox: Sandbox) -> None:
    dies = LibraryFile("meurt", ("meurt",), b"import os\ndef meurt():\n    os._exit(3)\n", sealed=True)
    source = b"from mes_fonctions import meurt\ndef f():\n    return meurt()\n"
    with sandbox.open(source, kit=Kit("trousse", library=(dies,))) as session, pytest.raises(SandboxFault):
        session.call("f")


def test_where_nothing_is_offered_there_is_no_module_and_no_process(sandbox: Sandbox) -> None:
    """A call that a program forges is then an answer that it forges."""
    source = (
        b"""
import os, struct
from server_free import nothing
""".replace(b"from server_free import nothing\n", b"")
        + b"""
def f():
    payload = b"N"
    os.write(230, struct.pack("<IQB", len(payload), 0, 32) + payload)
    return 1
"""
    )
    kit = Kit("trousse", {"seed": 4}, library=(replace(SEALED, offered=False),))
    with sandbox.open(source, kit=kit) as session, pytest.raises(ProgramFault) as caught:
        session.call("f")
    assert caught.value.kind is FaultKind.INVALID_OUTPUT
    with pytest.raises(ProgramFault) as absent:
        sandbox.open(b"from mes_fonctions import triple\n", kit=kit)
    assert absent.value.kind is FaultKind.IMPORT_ERROR


#: A program that looks for a word of the course's file in names, constants and bytes, and does not hold it itself.
HUNT = """
import builtins, dis, gc, importlib, inspect, io, marshal, os, pickle, struct, sys, types
import numpy as np
mf = {module}
triple = mf.triple
WORD = "quet" + "zal"
def texts(value, depth=0):
    if isinstance(value, str):
        yield value
    elif isinstance(value, (bytes, bytearray)):
        yield bytes(value).decode("latin-1")
    elif isinstance(value, types.CodeType):
        for part in (value.co_names, value.co_varnames, value.co_freevars, value.co_code, value.co_consts):
            yield from texts(part, depth)
    elif isinstance(value, types.FunctionType):
        yield from texts(value.__code__, depth)
    elif depth < 4 and isinstance(value, (list, tuple, set, frozenset)):
        for item in value:
            yield from texts(item, depth + 1)
    elif depth < 4 and isinstance(value, dict):
        yield from texts([*value.keys(), *value.values()], depth + 1)
def found(values):
    return sum(WORD in text and text != WORD for value in values for text in texts(value))
{attack}
def f():
    return attack()
"""
ATTACKS = {
    "code": """
def attack():
    cells = [cell.cell_contents for cell in triple.__closure__ or ()]
    return found([triple, triple.__globals__, triple.__defaults__, cells, vars(mf)])
""",
    "gc": """
def attack():
    triple(1)
    return found([held for held in gc.get_objects() if isinstance(held, (types.FunctionType, dict, tuple, list))])
""",
    "modules": """
def attack():
    triple(1)
    return found([vars(module) for module in list(sys.modules.values()) if isinstance(module, types.ModuleType)])
""",
    "dis": """
def attack():
    out = io.StringIO()
    dis.dis(triple, file=out)
    return found([out.getvalue()])
""",
    "source": """
def attack():
    try:
        return found([inspect.getsource(triple)])
    except OSError:
        return 0
""",
    "traceback": """
def attack():
    try:
        triple("a")
    except ValueError as error:
        frames, trace = [vars(error), error.args], error.__traceback__
        assert error.__cause__ is None and error.__context__ is None
        while trace:
            frames += [trace.tb_frame.f_code, list(trace.tb_frame.f_locals)]
            trace = trace.tb_next
        return found(frames)
""",
    "profile": """
def attack():
    codes = []
    sys.setprofile(lambda frame, event, arg: codes.append(frame.f_code))
    try:
        mf.norme([3.0, 4.0])
    finally:
        sys.setprofile(None)
    return found(codes)
""",
    "pickle": """
def attack():
    dumps = []
    for dump in (pickle.dumps, marshal.dumps, lambda held: marshal.dumps(held.__code__)):
        try:
            dumps.append(dump(triple))
        except Exception:
            pass
    return found(dumps)
""",
    "callback": """
def attack():
    callers = []
    def told(self, *others, **named):
        callers.append(sys._getframe(1).f_code)
        return self
    class Array(np.ndarray):
        __mul__ = __rmul__ = __array_ufunc__ = told
    class Text(str):
        __mul__ = __rmul__ = told
    class Number(float):
        __mul__ = __rmul__ = told
    class Own:
        __mul__ = __rmul__ = __array__ = told
    for argument in (np.ones(2).view(Array), Text("a"), Number(2.0), Own(), told):
        try:
            triple(argument)
        except Exception:
            pass
    return found([code for code in callers if code.co_filename.startswith("mes_fonctions")])
""",
    "monkeypatch": """
def attack():
    callers, kept = [], (np.sqrt, np.square, np.sum)
    def spy(*values, **named):
        callers.append(sys._getframe(1).f_code)
        return 0
    np.sqrt = np.square = np.sum = spy
    try:
        mf.norme([3.0, 4.0])
    finally:
        np.sqrt, np.square, np.sum = kept
    return found(callers)
""",
}  # fmt: skip
FOLDERS = """
def attack():
    for path in ("/proc/self/fd", "/proc/self/mem", "/proc/1/mem", f"/proc/{os.getppid()}/mem", "mes_fonctions"):
        try:
            os.open(path, os.O_RDONLY)
            return 1
        except OSError:
            pass
    return 0
"""
#: Writes calls of its own making on the pipe to the course, and counts the replies that are no refusal.
CRAFTED = """
def attack():
    triple(1)
    def ask(payload):
        os.write(228, struct.pack("<I", len(payload)) + payload)
        length, = struct.unpack("<I", os.read(227, 4))
        return os.read(227, length)
    def call(name):
        return THREE + b"s" + struct.pack("<I", len(name)) + name + b"t" + bytes(4) + b"d" + bytes(4)
    THREE = b"t" + struct.pack("<I", 3)
    crafted = [b"", b"N", b"t" + b"\\xff" * 4, b"s" + struct.pack("<I", 3) + b"abc", THREE + b"NNN"]
    names = b"SECRET", b"__dict__", b"__class__", b"cachee", b"np", b"__getattr__", b"__loader__"
    replies = [ask(payload) for payload in [*crafted, *map(call, names)]]
    return found(replies) + sum(b"raised" not in reply for reply in replies)
"""
SPELLINGS = [
    "__import__('mes_fonctions')",
    "importlib.import_module('mes_' + 'fonctions')",
    "__import__(''.join(['mes', chr(95), 'fonctions']))",
    "eval('__imp' + 'ort__(\"mes_fon\" + \"ctions\")')",
    "sys.modules[next(name for name in sys.modules if name.startswith('mes_f'))]",
    "next(o for o in gc.get_objects() if isinstance(o, types.ModuleType) and o.__name__.startswith('mes_f'))",
]


def hunt(sandbox: Sandbox, module: str, attack: str) -> object:
    return answer(sandbox, HUNT.format(module=module, attack=attack))


@pytest.mark.parametrize("attack", [*ATTACKS.values(), FOLDERS, CRAFTED], ids=[*ATTACKS, "folders", "crafted"])
def test_nothing_of_a_function_of_the_course_is_in_the_programs_process(sandbox: Sandbox, attack: str) -> None:
    assert hunt(sandbox, SPELLINGS[0], attack) == 0


@pytest.mark.parametrize("module", SPELLINGS[1:])
def test_no_spelling_gives_more(sandbox: Sandbox, module: str) -> None:
    assert hunt(sandbox, module, ATTACKS["code"]) == 0


def test_the_hunt_finds_what_is_there(sandbox: Sandbox) -> None:
    """The same functions as a student's own are found by each of these programs, where Python shows them at all."""
    kit = Kit("trousse", {"seed": 4}, library=(replace(SEALED, sealed=False),))
    for name, attack in ATTACKS.items():
        with sandbox.open(HUNT.format(module=SPELLINGS[0], attack=attack).encode(), kit=kit) as session:
            assert session.call("f").value != 0 or name == "source", name
