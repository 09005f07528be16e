"""What goes wrong: drawn from a seed, one after the other, each at a part that has no other fault at the time."""

from __future__ import annotations

import random
import signal
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from tests.benchmarks.chaos.park import Park, Part, Worker

#: A frozen part stays so for less or more than a lease, and than NATS waits for an answer.
FROZEN, AWAY, SHIFTED = (0.3, 9.0), (0.5, 3.0), (3.0, 8.0)
#: Then it is left alone for a while: long enough to be back, or not. PostgreSQL, which all stand on, for longer.
REST, LONG_REST = (0.0, 12.0), (10.0, 40.0)
SHIFTS = (-86400, -3600, -60, 60, 3600, 86400)


@dataclass(frozen=True)
class Kind:
    """`parts` are known by their places; what has begun at one ends after so many seconds, drawn between two."""

    name: str
    weight: float
    parts: int
    begin: Callable[[Park, int, random.Random], None]
    end: Callable[[Park, int], None]
    lasts: tuple[float, float]
    #: Parts that may have one fault at a time in all share a place.
    place: str


@dataclass
class Fault:
    """One that has happened; times are of `time.monotonic`."""

    kind: str
    part: str
    begun: float
    ended: float = float("inf")
    trouble: str = ""


def kinds(park: Park) -> Sequence[Kind]:
    """All that can be had on this machine."""
    webs, workers, nodes = len(park.webs), len(park.workers), len(park.nodes)
    found = [
        *_of_parts(park.webs, "web"),
        *_of_parts(park.workers, "worker"),
        Kind("NATS node killed", 2, nodes, _kill_node, lambda p, n: p.nodes[n].start(), AWAY, "node"),
        Kind("NATS node frozen", 2, nodes, _freeze_node, _thaw_node, FROZEN, "node"),
        Kind("PostgreSQL restarted", 0.5, 1, _stop("fast"), lambda p, _: p.postgres.start(), (0.0, 1.0), "postgres"),
        Kind("PostgreSQL crashed", 0.5, 1, _stop("immediate"), lambda p, _: p.postgres.start(), (0.0, 1.0), "postgres"),
        Kind("worker cut from NATS", 2, workers, _on_wires(park.workers, "cut"), _mend, FROZEN, "wires"),
        Kind("worker unheard by NATS", 2, workers, _on_wires(park.workers, "mute"), _mend, FROZEN, "wires"),
    ]
    if all(disk.can_fill for disk in park.disks):
        found.append(Kind("disk of a NATS node full", 1, nodes, _fill, _clear, SHIFTED, "node"))
    if park.clocks:
        found.append(Kind("clock jumps", 2, len(park.clocks), _shift, _unshift, SHIFTED, "clock"))
    assert webs
    return found


def _of_parts(parts: Sequence[Part], place: str) -> Iterator[Kind]:
    weight = 2 if place == "worker" else 1

    def kill(_park: Park, number: int, _draw: random.Random) -> None:
        parts[number].kill()

    def freeze(_park: Park, number: int, _draw: random.Random) -> None:
        parts[number].signal(signal.SIGSTOP)

    yield Kind(f"{place} killed", weight, len(parts), kill, lambda _, n: parts[n].start(), AWAY, place)
    thaw = lambda _, n: parts[n].signal(signal.SIGCONT)  # noqa: E731
    yield Kind(f"{place} frozen", 2, len(parts), freeze, thaw, FROZEN, place)


def _kill_node(park: Park, number: int, _draw: random.Random) -> None:
    park.nodes[number].stop()


def _freeze_node(park: Park, number: int, _draw: random.Random) -> None:
    _tell_node(park, number, signal.SIGSTOP)


def _thaw_node(park: Park, number: int) -> None:
    _tell_node(park, number, signal.SIGCONT)


def _tell_node(park: Park, number: int, what: signal.Signals) -> None:
    process = park.nodes[number].process
    assert process is not None
    process.send_signal(what)


def _stop(mode: str) -> Callable[[Park, int, random.Random], None]:
    return lambda park, _number, _draw: park.postgres.stop(mode)


def _on_wires(workers: Sequence[Worker], how: str) -> Callable[[Park, int, random.Random], None]:
    return lambda _park, number, _draw: getattr(workers[number].wires, how)()


def _mend(park: Park, number: int) -> None:
    park.workers[number].wires.mend()


def _fill(park: Park, number: int, _draw: random.Random) -> None:
    park.disks[number].fill()


def _clear(park: Park, number: int) -> None:
    """A node that could not write has put its JetStream off until it is started again."""
    park.disks[number].clear()
    park.nodes[number].stop()
    park.nodes[number].start()


def _shift(park: Park, number: int, draw: random.Random) -> None:
    park.clocks[number].shift_clock(draw.choice(SHIFTS))


def _unshift(park: Park, number: int) -> None:
    park.clocks[number].shift_clock(0)


@dataclass
class Monkey:
    """Brings a fault each `every` seconds, from a thread, until it is told to stop; then ends what has begun.

    With `over`, which tells whether a fault has been got over, each waits for that of the one before; and each kind has
    its turn.
    """

    park: Park
    seed: int
    every: float = 1.0
    only: frozenset[str] = frozenset()
    over: Callable[[Fault], bool] | None = None
    faults: list[Fault] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._draw = random.Random(self.seed)
        known = {kind.name: kind for kind in kinds(self.park)}
        if not self.only <= known.keys():
            raise ValueError(f"no such fault here: {sorted(self.only - known.keys())}; there are {[*known]}")
        self._kinds = [kind for name, kind in known.items() if not self.only or name in self.only]
        self._busy: set[tuple[str, int]] = set()
        self._told, self._pending = threading.Event(), list[threading.Thread]()
        self._thread = threading.Thread(target=self._run, name="monkey", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def tell(self) -> None:
        """To stop: what has begun ends now."""
        self._told.set()

    def stop(self) -> None:
        self.tell()
        self._thread.join()
        for one in self._pending:
            one.join()

    def _run(self) -> None:
        while not self._told.wait(self.every):
            drawn = self._drawn()
            if drawn is None:
                continue
            kind, number, lasts = drawn
            fault = Fault(kind.name, f"{kind.place}{number}", time.monotonic())
            draw = random.Random(self._draw.random())
            self.faults.append(fault)
            one = threading.Thread(target=self._befall, args=(fault, kind, number, lasts, draw), daemon=True)
            one.start()
            self._pending.append(one)
            while self.over is not None and not self.over(fault) and not self._told.wait(0.1):
                pass

    def _drawn(self) -> tuple[Kind, int, float] | None:
        turn = len(self.faults) % len(self._kinds)
        possible = self._kinds if self.over is None else [self._kinds[turn]]
        each = [(kind, number) for kind in possible for number in range(kind.parts)]
        free = [one for one in each if (one[0].place, one[1]) not in self._busy]
        if not free:
            return None
        kind, number = self._draw.choices(free, [kind.weight / kind.parts for kind, _ in free])[0]
        self._busy.add((kind.place, number))
        return kind, number, self._draw.uniform(*kind.lasts)

    def _befall(self, fault: Fault, kind: Kind, number: int, lasts: float, draw: random.Random) -> None:
        try:
            kind.begin(self.park, number, draw)
            self._told.wait(lasts)
            kind.end(self.park, number)
        except Exception:
            fault.trouble = traceback.format_exc()
        fault.ended = time.monotonic()
        if self.over is None:
            self._told.wait(draw.uniform(*(LONG_REST if kind.place == "postgres" else REST)))
        self._busy.discard((kind.place, number))


def happened(faults: Sequence[Fault]) -> Mapping[str, list[Fault]]:
    """By kind."""
    found: dict[str, list[Fault]] = {}
    for fault in faults:
        found.setdefault(fault.kind, []).append(fault)
    return found
