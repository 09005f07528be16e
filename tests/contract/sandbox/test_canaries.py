"""The corpus of hostile programs tests the walls: with its wall lifted, a program gets through.

Where other walls would stop it too, they are lifted in both runs: what differs is one wall. No limit of time decides:
what fills the memory stops by itself at three times its limit.
"""

from __future__ import annotations

from dataclasses import asdict

import pytest

from server.sandbox import ProgramFault, Sandbox, Value
from server.sandbox.cgroups import usable_hierarchies
from server.sandbox.child import template
from server.sandbox.child.walls import WALLS
from tests.sandbox.conftest import Lifting
from tests.sandbox.corpus import DRAWN, HOSTILE
from tests.sandbox.limits import only

POLICY = only(memory_bytes=64 << 20, folder_bytes=1 << 20)

#: More walls may be left down in both runs than would stop the program: these sets are those of the probe's assaults,
#: whose templates are the same.
CANARIES = [
    ("seccomp", "forbidden_operation/appel_ptrace", ()),
    ("landlock", "ok/lectures", ("seccomp", "view", "cgroup")),
    ("view", "forbidden_operation/mot_de_passe", ("seccomp", "landlock")),
    ("rlimits", "memory_limit/tableau", ("seccomp", "view", "cgroup")),
    ("cgroup", "memory_limit/pages_ecrites", ("seccomp", "rlimits")),
    ("pid", "ok/processus_enumeres", ("seccomp", "landlock")),
    ("environment", "ok/fuites", ()),
    ("descriptors", "ok/fuites", ()),
]


def outcome(sandbox: Sandbox, program: str, *, drawing: bool) -> str:
    """As in the tests of the corpus: the fault, or "ok" when both calls answer that nothing was reached."""
    context: dict[str, Value] = {name: value for name, value in asdict(POLICY).items() if isinstance(value, int)}
    context |= {"projet": __file__, "gabarit": template.__file__, "parent": 1}
    source = (HOSTILE / f"{program}.py").read_bytes() + DRAWN * drawing
    try:
        with sandbox.open(source, policy=POLICY, drawing=drawing) as session:
            answers = [session.call("repondre", context).value for _ in range(2)]
    except ProgramFault as fault:
        return str(fault.kind)
    return "ok" if answers == ["rien", "rien"] else f"reached: {answers}"


@pytest.mark.parametrize(
    "drawing",
    # That each wall stands around what draws too is proven in `test_drawing.py`.
    [pytest.param(False, id="numpy"), pytest.param(True, id="drawing", marks=pytest.mark.slow)],
)
@pytest.mark.parametrize(("wall", "program", "hiders"), CANARIES, ids=[wall for wall, _, _ in CANARIES])
def test_the_corpus_sees_that_a_wall_is_missing(
    without: Lifting, wall: str, program: str, hiders: tuple[str, ...], drawing: bool
) -> None:
    assert wall in WALLS
    if wall == "cgroup" and not usable_hierarchies()[0]:
        pytest.skip("no control group on this machine")
    filed = program.partition("/")[0]
    assert outcome(without(frozenset(hiders)), program, drawing=drawing) == filed
    through = outcome(without(frozenset({*hiders, wall})), program, drawing=drawing)
    assert through != filed
    assert through.startswith(("ok", "reached")), "a program that goes on to its end shows that nothing stopped it"
