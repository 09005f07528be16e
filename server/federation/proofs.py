"""What comes back of a sign-in, whatever the protocol: the answer of a browser, and the proof of who one is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class BrowserAnswer:
    """The query with which a browser comes back from a system; what is absent is empty."""

    state: str = ""
    ticket: str = ""
    code: str = ""
    issuer: str = ""
    error: str = ""


@dataclass(frozen=True)
class ProvenPerson:
    """A person whom a system has proved. `session` names the session there; `claims` are what a rule reads."""

    subject: str
    session: str
    claims: Mapping[str, Any]
