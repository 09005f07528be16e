"""What the log of a node says, phase by phase; read with care: it comes from the student's process."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from graders.core.contract.values import Floats, UnreadableError, Value, read_array
from graders.l20.noeud_ros.scenes import COMMAND, LASER_SCAN, PERIOD, SCAN, TWIST, Pace

#: A moment before the first scan of a phase: instants are sums of tenths.
EARLY = 1e-6
MOST_TOLD = 6
NUMBERS = 6


class Did(IntEnum):
    """What a node did in a phase."""

    NOTHING = 0
    STOPPED = 1
    """It published a zero Twist, and still does at the end."""
    STOPPED_AT_FIRST = 2
    """It did, and is silent at the end."""
    MOVED = 3
    """It published another Twist than zero."""


@dataclass(frozen=True)
class Log:
    """What a node published on /cmd_vel as Twist (instants, the six numbers), and all that it hears and says.

    `refused` are the changes of the parameter that it did not accept, with the reason that it gave.
    """

    instants: Floats
    numbers: Floats
    heard: tuple[tuple[str, str], ...]
    announced: tuple[tuple[str, str], ...]
    refused: tuple[str, ...]

    @property
    def hears_scans(self) -> bool:
        return (SCAN, LASER_SCAN) in self.heard

    @property
    def commands(self) -> bool:
        return (COMMAND, TWIST) in self.announced

    def did(self, phase: int, pace: Pace) -> Did:
        start = phase * pace.length + pace.calm * PERIOD - EARLY
        end, settled = (phase + 1) * pace.length - EARLY, start + pace.settling * PERIOD
        own = (self.instants >= phase * pace.length - EARLY) & (self.instants < end)
        if np.any(self.numbers[own]):
            return Did.MOVED
        if not np.any(own & (self.instants >= start)):
            return Did.NOTHING
        return Did.STOPPED if np.any(own & (self.instants >= settled)) else Did.STOPPED_AT_FIRST


def right(did: Did, *, stop: bool) -> bool:
    """Is that what was asked for?"""
    return did in ((Did.STOPPED, Did.STOPPED_AT_FIRST) if stop else (Did.NOTHING, Did.STOPPED_AT_FIRST))


def read_log(value: Value) -> Log:
    """The log that the kit makes. Raises UnreadableError for anything else."""
    if not isinstance(value, dict):
        raise UnreadableError("ce n'est pas le compte rendu d'un nœud")
    instants, numbers = _commands(value)
    return Log(
        instants,
        numbers,
        tuple(_pairs(value.get("abonnements"))),
        tuple(_pairs(value.get("editeurs"))),
        tuple(_refused(value.get("reglages"))),
    )


def _commands(value: dict[str, Value]) -> tuple[Floats, Floats]:
    for said in _dictionaries(value.get("publications")):
        if _is(said.get("topic"), COMMAND) and _is(said.get("type"), TWIST):
            instants, numbers = read_array(said.get("t")), read_array(said.get("valeurs"))
            if instants.ndim != 1 or numbers.shape != (len(instants), NUMBERS):
                raise UnreadableError("ce n'est pas le compte rendu d'un nœud")
            return instants, numbers
    return np.zeros(0), np.zeros((0, NUMBERS))


def _is(value: Value, text: str) -> bool:
    """An array would be compared item by item."""
    return isinstance(value, str) and value == text


def _dictionaries(values: Value) -> Iterator[dict[str, Value]]:
    if isinstance(values, (list, tuple)):
        yield from (one for one in values if isinstance(one, dict))


def _pairs(values: Value) -> Iterator[tuple[str, str]]:
    for one in values if isinstance(values, (list, tuple)) else ():
        if isinstance(one, (list, tuple)) and len(one) == 2:
            yield str(one[0])[:80], str(one[1])[:80]


def _refused(values: Value) -> Iterator[str]:
    """A change that no node accepted; only the one that has declared the parameter may."""
    answers = list(_dictionaries(values))
    taken = {one.get("t") for one in answers if one.get("accepte") is True and isinstance(one.get("t"), float)}
    for one in answers:
        if isinstance(one.get("t"), float) and one.get("t") not in taken:
            yield str(one.get("raison"))[:200]


def circumstances(log: Log) -> str:
    """Why nothing could come of it, in French; "" when all is in place."""
    if not log.hears_scans:
        topics = ", ".join(f"{topic} ({kind})" for topic, kind in log.heard[:MOST_TOLD])
        others = f" (il écoute : {topics})" if topics else ""
        return f" Votre nœud n'est pas abonné à {SCAN} avec le type LaserScan{others}."
    if not log.commands:
        topics = ", ".join(f"{topic} ({kind})" for topic, kind in log.announced[:MOST_TOLD])
        others = f" (il annonce : {topics})" if topics else ""
        return f" Votre nœud n'a pas d'éditeur de Twist sur {COMMAND}{others}."
    if log.refused:
        return f" Votre nœud a refusé le nouveau réglage : « {log.refused[0]} »."
    return ""
