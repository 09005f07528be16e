"""No expected answer is in a child: a program that walks through all of it finds nothing of a solution or a mistake.

What to look for is taken from the catalogue: the names and the texts of the misconceptions, the lines and the compiled
functions of the solutions and of the mistakes, but for those that students are given. The program (`hostile/marcheur`)
hands over all that it reaches: objects, code, the memory around them, what was given back included, and the files that
it sees. It is compared here. A decoy, which the template holds as it holds a kit, is all that must be found.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import CodeType

import numpy as np
import pytest
from numpy.typing import NDArray

import server.sandbox
from graders.core.code.folder import Misconception
from graders.core.code.grading import CodeGrader
from server.sandbox import Sandbox, Value
from tests.sandbox.limits import only
from tests.support.quick import some, the_course

TESTS = Path(__file__).resolve().parents[2]
WALKER = (TESTS / "hostile" / "marcheur.py").read_bytes()
POLICY = only(memory_bytes=2 << 30, frame_bytes=256 << 20, session_bytes=256 << 20)
#: Shorter lines say what anybody would write, and shorter functions are made of a few instructions that many have.
LINE, CODE = 28, 48
WORD = 8
FILENAME = "solution.py"

DECOY = '''
ERREUR = "leurre_du_catalogue"
def leurre(pose, cible):
    """Un texte de leurre, que le catalogue ne contient pas."""
    cap_du_leurre = np.arctan2(cible[1] - pose[1], cible[0] - pose[0])
    return np.array([cap_du_leurre - pose[2], np.hypot(*(cible - pose)[:2]), 0.125])
def configurer(seed=None):
    return {}
'''
OURS = {"graders", "curriculum", "misconceptions", "solution.py", "grader.py"}
#: The functions of the walker, and what they are made of.
OWN = set(re.findall(r"^def (\w+)\(", WALKER.decode(), re.MULTILINE))
DECOYS = ["nom leurre", "ligne leurre (objets)", "ligne leurre (mémoire)", "code leurre"]


def mistakes() -> Iterator[Misconception]:
    for grader in graders():
        yield from grader.misconceptions


def graders() -> list[CodeGrader]:
    exercises = (exercise for module in the_course().modules.values() for exercise in module.exercises)
    return some(exercise.grader for exercise in exercises if isinstance(exercise.grader, CodeGrader))


def functions(code: CodeType) -> Iterator[bytes]:
    """The instructions of every function of a file that is not too short, and the names that they speak of."""
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            if len(inner.co_code) >= CODE:
                yield inner.co_code + " ".join(inner.co_names + inner.co_varnames).encode()
            yield from functions(inner)


def compiled(source: str) -> set[bytes]:
    """With and without an import that the kit makes needless: calls of what is imported are other instructions."""
    texts = (source, f"import numpy as np\n{source}")
    return {code for text in texts for code in functions(compile(text, "solution.py", "exec", dont_inherit=True))}


def lines(text: str) -> set[str]:
    return {line.strip() for line in text.splitlines() if len(line.strip().encode()) >= LINE}


def given() -> tuple[set[str], set[bytes]]:
    """The lines and the functions that students are shown before they have solved anything."""
    texts, sources = [], []
    for module in the_course().modules.values():
        sources += [text for files in module.kits.values() for text in files.values()]
        for exercise in module.exercises:
            sources.append(exercise.starter)
            texts += [text.source.path.read_text() for text in (exercise.statement, *exercise.hint_texts)]
    public = set().union(*map(lines, texts + sources))
    return public, set().union(*map(compiled, sources))


def needles() -> tuple[dict[bytes, str], dict[bytes, str], dict[bytes, str]]:
    """Whole names, lines, and instructions of functions, with what each is."""
    public, shown = given()
    sources = {"leurre": DECOY} | {f"{grader.exercise} solution": grader.solution for grader in graders()}
    sources |= {f"{mistake.id} {k}": mistake.source for k, mistake in enumerate(mistakes())}
    names = {mistake.id: mistake.id for mistake in mistakes() if "_" in mistake.id} | {"leurre_du_catalogue": "leurre"}
    told = {
        line: f"{mistake.id} told"
        for mistake in mistakes()
        for text in (mistake.title, mistake.explanation, mistake.question)
        for line in lines(text)
    }
    written = {line: place for place, source in sources.items() for line in lines(source) - public} | told
    made = {code: place for place, source in sources.items() for code in compiled(source) - shown}
    return (
        {name.encode(): f"nom {place}" for name, place in names.items()},
        {line.encode(): f"ligne {place}" for line, place in written.items()},
        {code: f"code {place}" for code, place in made.items()},
    )


def within(sought: Mapping[bytes, str], hay: bytes) -> set[bytes]:
    """Which of these, of 15 bytes at least, occur in the hay: one word in eight is compared with all theirs."""
    words = np.frombuffer(hay[: len(hay) // WORD * WORD], "<u8")
    begins: dict[int, list[tuple[bytes, int]]] = {}
    for needle in sought:
        for shift in range(WORD):
            begins.setdefault(int.from_bytes(needle[shift : shift + WORD], "little"), []).append((needle, shift))
    known = np.zeros(1 << 20, dtype=bool)
    known[_hashed(np.array([*begins], dtype="<u8"))] = True
    candidates = np.flatnonzero(known[_hashed(words)])
    pairs = zip(candidates.tolist(), words[candidates].tolist(), strict=True)
    return {
        needle
        for at, word in pairs
        for needle, shift in begins.get(word, ())
        if hay.startswith(needle, WORD * at - shift)
    }


def _hashed(words: NDArray[np.uint64]) -> NDArray[np.uint64]:
    return (words * np.uint64(0x9E3779B97F4A7C15)) >> np.uint64(44)


def found(texts: bytes, codes: bytes, memory: bytes) -> Iterable[str]:
    """What each needle is that was found. Without its zeros, memory holds all text as bytes, however wide it was."""
    names, written, made = needles()
    for name in names.keys() & set(texts.split(b"\0")):
        yield names[name]
    for where, hay in (("objets", texts), ("mémoire", memory.replace(b"\0", b""))):
        yield from (f"{written[line]} ({where})" for line in within(written, hay))
    at = 0
    while at < len(codes):
        end = at + 4 + int.from_bytes(codes[at : at + 4], "little")
        if (code := codes[at + 4 : end]) in made:
            yield made[code]
        at = end


def origins_of(filename: str, origins: bytes) -> set[str]:
    """The names of the functions that were compiled from this file."""
    pairs = (origin.rpartition(":") for origin in origins.decode().split("\0"))
    return {name.partition(".")[0] for file, _, name in pairs if file == filename} - {"<module>"}


def walked(source: bytes, *, namespaces: bool | None = None, drawing: bool = False) -> list[bytes]:
    """What the walker brings back of a template that also holds the decoy, as one more kit."""
    kits = {**the_course().kits, "leurre": "import numpy as np\n" + DECOY}
    with Sandbox(kits, POLICY, namespaces=namespaces) as sandbox, sandbox.open(source, drawing=drawing) as session:
        answer: Value = session.call("repondre").value
    assert isinstance(answer, tuple)
    return [bytes(np.asarray(part, dtype=np.uint8)) for part in answer]


def assert_nothing_but_the_decoy(brought: list[bytes]) -> None:
    *contents, origins, files = brought
    assert sorted(set(found(*contents))) == sorted(DECOYS)
    assert origins_of(FILENAME, origins) == OWN, "what was rehearsed is still there"
    seen = some(files.decode().split("\0"))
    assert not [path for path in seen if OURS & set(Path(path).parts)]
    assert len(seen) > 100


def test_nothing_of_a_course_is_in_the_code_of_the_sandbox() -> None:
    """Its samples, too, are programs: none has a function that an exercise asks for."""
    asked = {function.name for exercise in the_course().exercises.values() for function in exercise.functions}
    texts = some(path.read_text() for path in Path(server.sandbox.__file__).parent.rglob("*.py"))
    defined = {name for text in texts for name in re.findall(r"\bdef (\w+)\(", text)}
    assert len(asked) > 5
    assert asked & defined == set()


def test_a_program_that_walks_through_its_whole_process_finds_no_answer() -> None:
    assert_nothing_but_the_decoy(walked(WALKER))


@pytest.mark.slow
@pytest.mark.parametrize("namespaces", [None, False], ids=["walls-of-the-machine", "without-namespaces"])
@pytest.mark.parametrize("library", ["numpy", "scipy", "matplotlib"])
def test_nor_does_one_of_any_template(library: str, namespaces: bool | None) -> None:
    source = WALKER + f"\nimport {library}\n".encode()
    assert_nothing_but_the_decoy(walked(source, namespaces=namespaces, drawing=library == "matplotlib"))
