"""One sandbox for the tests of a worker, with small kits; and one for each set of walls left down."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import cache

import pytest

from server.sandbox import Kit, Policy, ProgramFault, Sandbox

from .corpus import OUTILS
from .family import OTHERS, SHARED, children
from .limits import FAR, only

KIT = """
import numpy as np

def configurer(libres=None, portee_max=12.0, seed=0):
    rng = np.random.default_rng(seed)
    def lidar(pose, n_rayons=36, bruit=0.0):
        return np.full(n_rayons, portee_max) + bruit * rng.normal(size=n_rayons)
    return {"np": np, "libres": libres, "PORTEE_MAX": portee_max, "rng": rng, "lidar": lidar}
"""

#: With less in it, for programs that reuse functions.
STEP_KIT = """
def configurer(seed=None, pas=2):
    return {"PAS": pas}
"""

POLICY = only(memory_bytes=128 << 20, frame_bytes=1 << 20, stdout_bytes=1 << 14)

Lifting = Callable[[frozenset[str]], Sandbox]


@pytest.fixture(scope="session")
def sandbox() -> Iterator[Sandbox]:
    with Sandbox({"trousse": KIT, "pas": STEP_KIT}, POLICY) as shared:
        SHARED.append(shared)
        yield shared


@pytest.fixture(scope="session")
def without() -> Iterator[Lifting]:
    """The sandbox in which these walls are down, with the kit of the hostile programs.

    Each costs a template for each import set that is asked of it, which all the tests of a worker share. Only the one
    whose walls all stand, as in service, has spare children.
    """
    with ExitStack() as stack:

        @cache
        def sandbox_of(lifted: frozenset[str]) -> Sandbox:
            made = Sandbox({"outils": OUTILS}, FAR, spares=int(not lifted), lifted=lifted)
            SHARED.append(made)
            return stack.enter_context(made)

        yield sandbox_of


@pytest.fixture
def alone() -> None:
    """For who looks at the processes of a sandbox of its own: those of the others are known."""
    OTHERS.clear()
    OTHERS.update(children(os.getpid()))


@pytest.fixture
def kit() -> Kit:
    return Kit("trousse", {"portee_max": 7.0, "seed": 42})


@pytest.fixture
def fault_of(sandbox: Sandbox) -> Callable[..., ProgramFault]:
    """Runs a program and calls its function f; returns the fault that must come of it."""

    def run(source: str | bytes, *args: object, policy: Policy | None = None) -> ProgramFault:
        data = source.encode() if isinstance(source, str) else source
        with pytest.raises(ProgramFault) as caught, sandbox.open(data, policy=policy) as session:
            session.call("f", *args)  # type: ignore[arg-type]
        return caught.value

    return run
