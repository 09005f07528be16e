"""The poses and the messages that submissions are graded on: by hand, one for each edge, then drawn.

Dates are whole milliseconds, so that none is told from another by rounding. No two headings between which one
interpolates are half a turn apart.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from graders.core.contract.values import Arguments, Floats
from graders.l20.tf_date.truth import Message, half_turns, right_lookup

QUARTER = math.pi / 2
#: Links of a tree, at most.
MOST_LINKS = 6
#: Seed of what never changes.
TELLING = 8
NAMES = ("map", "odom", "base", "laser", "camera", "imu", "bras", "pince", "tour", "roue")


def pose(x: float, y: float, theta: float) -> Floats:
    return np.array([x, y, theta], dtype=np.float64)


def plain_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    """Both ends, the middle, a quarter; turns of less than half that do not cross the back."""
    yield pose(0, 0, 0), pose(4, 2, 0), 0.5
    yield pose(1, -2, 0.5), pose(1, -2, 1.5), 0.25
    yield pose(2, 3, -1), pose(6, -1, 1), 0.25
    yield pose(2, 3, -1), pose(6, -1, 1), 0.0
    yield pose(2, 3, -1), pose(6, -1, 1), 1.0
    yield pose(0, 1, 0.2), pose(-3, 5, 2.8), 0.125
    for _ in range(4):
        x, y = _where(rng), _where(rng)
        start = float(np.round(rng.uniform(-3.0, 0.0), 2))
        yield pose(*x, start), pose(*y, start + float(np.round(rng.uniform(0.3, 2.9), 2))), _share(rng)


def pairs_across_the_back(rng: np.random.Generator) -> Iterator[Arguments]:
    """From 170 to -170 degrees, and back; turns of nearly half; a middle that falls on either side of the back."""
    yield pose(0, 0, 3), pose(0, 0, -3), 0.5
    yield pose(0, 0, -3), pose(2, 0, 3), 0.25
    yield pose(1, 1, 2), pose(3, -1, -2), 0.75
    yield pose(1, 1, -1.5), pose(3, -1, 2.5), 0.25
    yield pose(0, 2, 3), pose(4, 0, -3), 0.9
    yield pose(0, 2, 3), pose(4, 0, -3), 0.1
    yield pose(0, 2, 1.7), pose(4, 0, -1.7), 0.7
    for _ in range(5):
        a = float(np.round(rng.uniform(1.7, 3.1), 2))
        b = -float(np.round(rng.uniform(1.7, 3.1), 2))
        first, last = (a, b) if rng.random() < 0.5 else (b, a)
        yield pose(*_where(rng), first), pose(*_where(rng), last), _share(rng)


def dates_inside(rng: np.random.Generator) -> Iterator[Arguments]:
    """A known date, first, last and between; two dates; unequal gaps; across the back."""
    two = np.array([[0.0, 0, 0], [4, 2, 1]])
    yield np.array([1.0, 3.0]), two, 2.0
    yield np.array([1.0, 3.0]), two, 1.5
    yield np.array([1.0, 3.0]), two, 1.0
    yield np.array([1.0, 3.0]), two, 3.0
    three = np.array([[0.0, 0, 0], [1, 0, 1], [5, 4, 2]])
    yield np.array([0.0, 1.0, 5.0]), three, 1.0
    yield np.array([0.0, 1.0, 5.0]), three, 2.0
    yield np.array([0.0, 1.0, 5.0]), three, 0.25
    yield np.array([-2.0, -1.0]), np.array([[1.0, 1, 3], [1, 2, -3]]), -1.5
    many = np.arange(20.0)
    yield many, np.column_stack([many**2, -many, 0.1 * many]), 17.5
    yield many, np.column_stack([many**2, -many, 0.1 * many]), 19.0
    for source, count in ((np.random.default_rng(TELLING), 3), (rng, 4)):
        for _ in range(count):
            dates, poses = _history(source, int(source.integers(3, 7)))
            k = int(source.integers(1, len(dates)))
            yield dates, poses, float(np.round(dates[k - 1] + (dates[k] - dates[k - 1]) * source.uniform(0.1, 0.9), 3))


def dates_at_the_ends(rng: np.random.Generator) -> Iterator[Arguments]:
    """Too late, too early, by little and by much; one date alone, which answers for itself."""
    dates, poses = np.array([1.0, 2.0, 4.0]), np.array([[0.0, 0, 0], [1, 0, 0.5], [5, 0, 1]])
    yield dates, poses, 5.0
    yield dates, poses, 0.0
    yield dates, poses, 4.001
    yield dates, poses, 0.999
    yield np.array([2.0]), np.array([[1.0, 2, 0.5]]), 2.0
    yield np.array([2.0]), np.array([[1.0, 2, 0.5]]), 2.5
    yield np.array([2.0]), np.array([[1.0, 2, 0.5]]), -1.0
    yield dates, poses, 4.0
    yield dates, poses, 1.0
    for _ in range(2):
        known, where = _history(rng, 4)
        yield known, where, float(known[-1]) + 0.5
        yield known, where, float(known[0]) - 0.25


def fixed(parent: str, child: str, *where: float) -> Message:
    return parent, child, None, pose(*where)


def dated(parent: str, child: str, date: float, *where: float) -> Message:
    return parent, child, date, pose(*where)


STATED: list[Message] = [
    fixed("base", "laser", 0.5, 0, 0),
    dated("map", "odom", 10.0, 0, 1, 0),
    dated("odom", "base", 10.0, 0, 0, 0),
    dated("map", "odom", 11.0, 0, 1, 0),
    dated("odom", "base", 11.0, 2, 0, QUARTER),
]
TURNED: list[Message] = [fixed("a", "b", 1, 2, QUARTER), fixed("b", "c", 3, 0, 0.5)]
SHUFFLED: list[Message] = [
    dated("odom", "base", 3.0, 4, 0, 1.5),
    dated("odom", "base", 1.0, 0, 0, 0),
    dated("odom", "base", 2.0, 1, 0, 0.5),
]
LIKE_NAMED: list[Message] = [
    fixed("base", "base_laser", 1, 0, 0.5),
    fixed("map", "base", 2, 1, QUARTER),
    fixed("base", "bas", 0, 3, 1),
]
CHAIN: list[Message] = [fixed(parent, child, 1, 0.5, 0.25) for parent, child in pairwise("abcdefg")]
#: A camera that is silent, an arm that has not begun: none of them on the way from the laser.
SILENT: list[Message] = [
    dated("odom", "base", 5.0, 0, 0, 1),
    dated("base", "bras", 9.0, 1, 1, 1),
    dated("odom", "base", 6.0, 2, 0, 1),
    dated("base", "camera", 1.0, 0, 1, 2),
    fixed("base", "laser", 0.2, 0.1, 3),
]


def chains(rng: np.random.Generator) -> Iterator[Arguments]:
    """One fixed link, two, the example of the statement, messages out of order, a part of the way, silent frames."""
    yield [fixed("base", "laser", 0.5, 0.25, 1)], "base", "laser", 0.0
    yield TURNED, "a", "c", 7.0
    yield [dated("odom", "base", 1.0, 0, 0, 0), dated("odom", "base", 2.0, 2, 4, 1)], "odom", "base", 1.25
    yield [dated("odom", "base", 0.0, 0, 0, 0), dated("odom", "base", 2.0, 2, 4, 1)], "odom", "base", 0.5
    yield STATED, "map", "laser", 10.5
    yield STATED, "odom", "laser", 10.25
    yield STATED, "map", "base", 11.0
    yield [dated("odom", "base", 4.0, 1, 2, 0.5), fixed("base", "laser", 1, 0, 1)], "odom", "laser", 4.0
    yield SHUFFLED, "odom", "base", 1.5
    yield SHUFFLED, "odom", "base", 2.5
    yield SILENT, "odom", "laser", 5.5
    # Dates whose texts are in another order; names that begin alike; six links.
    yield [dated("odom", "base", t, x, 0, 0) for t, x in ((9.0, 1), (10.0, 3), (11.0, 4))], "odom", "base", 9.5
    yield LIKE_NAMED, "map", "base", 3.0
    yield LIKE_NAMED, "map", "base_laser", 3.0
    yield CHAIN, "a", "g", 0.0
    for source, count in ((np.random.default_rng(TELLING), 3), (rng, 3)):
        yield from (_lookup(source) for _ in range(count))


def refusals(rng: np.random.Generator) -> Iterator[Arguments]:
    """Frames that are unknown, or not above; dates that one link of the way does not know; and what is no fault."""
    yield STATED, "map", "camera", 10.5
    yield STATED, "monde", "laser", 10.5
    yield STATED, "laser", "map", 10.5
    yield STATED, "map", "laser", 11.25
    yield STATED, "map", "laser", 9.0
    yield STATED, "base", "laser", 99.0
    yield STATED, "map", "map", 99.0
    yield STATED, "laser", "laser", 10.5
    yield [*STATED, fixed("base", "camera", 0, 1, 2)], "laser", "camera", 10.5
    yield SILENT, "odom", "laser", 6.5
    yield SILENT, "base", "bras", 5.5
    yield [*STATED, fixed("odom", "tour", 1, 1, 1)], "base", "tour", 10.5
    late = [*STATED[:3], dated("map", "odom", 10.2, 0, 1, 0.5), STATED[4]]
    yield late, "map", "laser", 10.5
    yield late, "odom", "laser", 10.5
    messages, target, source, _ = _lookup(rng)
    yield messages, target, source, 500.0
    yield messages, target, "inconnu", 20.0


def _where(rng: np.random.Generator) -> tuple[float, float]:
    x, y = np.round(rng.uniform(-5.0, 5.0, 2), 1)
    return float(x), float(y)


def _share(rng: np.random.Generator) -> float:
    return float(np.round(rng.uniform(0.05, 0.95), 2))


def _history(rng: np.random.Generator, count: int) -> tuple[Floats, Floats]:
    """Dates (n,), increasing by unequal gaps, and poses (n, 3)."""
    while True:
        dates = np.round(10.0 + np.cumsum(rng.uniform(0.1, 3.0, count)), 1)
        poses = np.column_stack([rng.uniform(-5.0, 5.0, (count, 2)), rng.uniform(-3.1, 3.1, count)]).round(2)
        if np.all(np.diff(dates) > 0.0) and not half_turns(dates, poses):
            return dates, poses


def _lookup(rng: np.random.Generator) -> Arguments:
    """A chain of two to four links and a branch beside it, in any order, asked at a date that all dated links know."""
    names = [str(name) for name in rng.permutation(NAMES)]
    links = int(rng.integers(2, 5))
    date = 20.0 + float(np.round(rng.uniform(0.2, 3.8), 3))
    messages: list[Message] = []
    for parent, child in pairwise(names[: links + 1]):
        messages += _link(rng, parent, child, around=date)
    messages += _link(rng, names[1], names[links + 1], around=None)
    order = rng.permutation(len(messages))
    return [messages[k] for k in order], names[0], names[links], date


def _link(rng: np.random.Generator, parent: str, child: str, *, around: float | None) -> Sequence[Message]:
    if around is not None and rng.random() < 0.35:
        return [(parent, child, None, pose(*_where(rng), float(np.round(rng.uniform(-3.1, 3.1), 2))))]
    dates, poses = _history(rng, int(rng.integers(2, 5)))
    if around is not None:
        share = rng.uniform(0.1, 0.9)
        dates = np.round(dates + around - (dates[0] + share * (dates[-1] - dates[0])), 3)
    return [(parent, child, float(t), where) for t, where in zip(dates, poses, strict=True)]


def are_messages(args: Arguments) -> bool:
    """Does every link keep what the statement promises, is it one tree, and does what is asked deserve one answer?"""
    messages, target, source, date = args
    parents = {message[1]: message[0] for message in messages}
    if not messages or len(parents) > MOST_LINKS or len(set(parents.values()) - set(parents)) != 1:
        return False
    if target == source and target not in {*parents, *parents.values()}:
        return False
    for child in parents:
        own = [message for message in messages if message[1] == child]
        dates = [message[2] for message in own]
        if len({message[0] for message in own}) > 1 or len(set(dates)) < len(dates) or (None in dates and dates[1:]):
            return False
        if None not in dates and half_turns(np.array(dates), np.array([message[3] for message in own])):
            return False
    above = ancestors(parents, source)
    if target in above:
        return True
    return all(isinstance(right_lookup(messages, parent, child, date), np.ndarray) for child, parent in pairwise(above))


def ancestors(parents: Mapping[str, str], frame: str) -> list[str]:
    """The frame, its parent, and so on up to the root."""
    way = [frame]
    while way[-1] in parents:
        way.append(parents[way[-1]])
    return way


def is_history(args: Arguments) -> bool:
    dates, poses, _ = args
    return bool(len(dates) and np.all(np.diff(dates) > 0.0)) and not half_turns(dates, poses)


def turns_ahead(args: Arguments) -> bool:
    """Is it a part of a turn that does not cross the back?"""
    a, b, share = args
    return bool(0.0 <= share <= 1.0 and abs(b[2] - a[2]) < math.pi - 0.05)


def turns_across_the_back(args: Arguments) -> bool:
    a, b, share = args
    return bool(0.0 <= share <= 1.0 and abs(b[2] - a[2]) > math.pi + 0.05)
