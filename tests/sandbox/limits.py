"""The limits of the tests: out of reach but for the one that a test is about, so that no verdict hangs on the pace of
the machine."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from server.sandbox import Policy

FAR = Policy(cpu_seconds=60.0, wall_seconds=300.0)


def only(**near: Any) -> Policy:
    """A policy whose limits of time are out of reach unless they are named."""
    return replace(FAR, **near)
