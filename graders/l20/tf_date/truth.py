"""What is right in l20/tf_date, from `reference.frames`: a pose, or the name of the exception that must be raised."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graders.core.contract.values import Floats
from reference.frames import NANOSECONDS, FrameBuffer, FutureDateError, PastDateError, Transform, interpolate

#: parent, child, date in seconds or None for a fixed transform, pose (3,) of the child in the parent.
Message = tuple[str, str, float | None, Floats]

UNKNOWN_FRAME, UNKNOWN_DATE = "KeyError", "ValueError"
#: As long as all that is ever asked.
KEPT_NS = 10_000 * NANOSECONDS


def right_between(a: Floats, b: Floats, share: float) -> Floats:
    return interpolate(Transform.from_planar(a), Transform.from_planar(b), share).to_planar()


def right_at(dates: Floats, poses: Floats, date: float) -> Floats | str:
    """The pose at a date, or UNKNOWN_DATE."""
    messages = [("a", "b", float(t), pose) for t, pose in zip(dates, poses, strict=True)]
    return right_lookup(messages, "a", "b", date)


def right_lookup(messages: Sequence[Message], target: str, source: str, date: float) -> Floats | str:
    """The pose (3,) of the source in the target, an ancestor of it; or UNKNOWN_FRAME, UNKNOWN_DATE."""
    if target == source:
        return np.zeros(3)
    frame, parents = source, {child: parent for parent, child, _, _ in messages}
    while frame != target:
        if frame not in parents:
            return UNKNOWN_FRAME
        frame = parents[frame]
    buffer = FrameBuffer(KEPT_NS)
    for parent, child, t, pose in messages:
        buffer.add(parent, child, Transform.from_planar(pose), _ns(t or 0.0), static=t is None)
    try:
        return buffer.lookup(target, source, _ns(date)).to_planar()
    except (FutureDateError, PastDateError):
        return UNKNOWN_DATE


def half_turns(dates: Floats, poses: Floats) -> bool:
    """Do two successive headings differ by about half a turn, so that neither way is the shorter?"""
    gaps = np.abs(np.diff(poses[np.argsort(dates), 2]))
    return bool(np.any(np.abs(gaps - np.pi) < 0.05))


def _ns(seconds: float) -> int:
    return round(seconds * NANOSECONDS)
