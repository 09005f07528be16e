"""One sandbox with the kit of declared exercises."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from graders.core.contract.kits import scenario_kit
from server.sandbox import Policy, Sandbox

#: None of the programs comes near to it but those that never end, of which each takes all of it.
POLICY = Policy(cpu_seconds=0.15, wall_seconds=2.0)


@pytest.fixture(scope="session")
def sandbox() -> Iterator[Sandbox]:
    with Sandbox(scenario_kit()) as shared:
        yield shared
