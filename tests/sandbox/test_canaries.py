"""The corpus of hostile programs tests the walls: with its wall lifted, a program does not get its outcome any more.

Where other walls would stop it too, they are lifted in both runs: what differs is one wall.
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import pytest

from server.sandbox import Policy, ProgramFault, Sandbox, Value
from server.sandbox.cgroups import hierarchies
from server.sandbox.child import template
from server.sandbox.child.walls import WALLS

HOSTILE = Path(__file__).resolve().parents[1] / "hostile"
POLICY = Policy(cpu_seconds=0.5, memory_bytes=64 << 20, folder_bytes=1 << 20)

CANARIES = [
    ("seccomp", "forbidden_operation/appel_ptrace", ()),
    ("landlock", "ok/lectures", ("seccomp", "view")),
    ("view", "forbidden_operation/mot_de_passe", ("landlock",)),
    ("rlimits", "memory_limit/tableau", ("cgroup",)),
    ("cgroup", "memory_limit/liste_sans_fin", ("rlimits",)),
    ("pid", "ok/processus_enumeres", ("seccomp", "landlock")),
    ("environment", "ok/fuites", ()),
    ("descriptors", "ok/fuites", ()),
]


def outcome(program: str, lifted: frozenset[str]) -> str:
    """As in the tests of the corpus: the fault, or "ok" when both calls answer that nothing was reached."""
    context: dict[str, Value] = {name: value for name, value in asdict(POLICY).items() if isinstance(value, int)}
    context |= {"projet": __file__, "gabarit": template.__file__, "parent": 1}
    source = (HOSTILE / f"{program}.py").read_bytes()
    with Sandbox({}, POLICY, spares=0, lifted=lifted) as sandbox:
        try:
            with sandbox.open(source) as session:
                answers = [session.call("repondre", context).value for _ in range(2)]
        except ProgramFault as fault:
            return str(fault.kind)
    return "ok" if answers == ["rien", "rien"] else f"reached: {answers}"


@pytest.mark.parametrize(("wall", "program", "hiders"), CANARIES, ids=[wall for wall, _, _ in CANARIES])
def test_the_corpus_sees_that_a_wall_is_missing(wall: str, program: str, hiders: tuple[str, ...]) -> None:
    assert wall in WALLS
    if wall == "cgroup" and not hierarchies()[0]:
        pytest.skip("no control group on this machine")
    filed = program.partition("/")[0]
    assert outcome(program, frozenset(hiders)) == filed
    assert outcome(program, frozenset({*hiders, wall})) != filed
