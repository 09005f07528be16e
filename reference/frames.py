"""Frames that move: transforms with their dates, kept in a buffer as tf2 does, and looked up at the date of a scan.

A tree: each frame has one parent, and a history of its pose there. Dates are whole nanoseconds, as ROS writes them; a
float of seconds since 1970 would be blind to 0.2 microseconds. `T_parent_child` maps coordinates of the child to
coordinates of the parent: a translation (3,) in metres, and a unit quaternion (x, y, z, w).

Between two dates the translation goes straight and evenly, the rotation along the shortest arc at constant speed
(slerp). Nothing is answered beyond the dates that are known: where a robot will be is a guess, and one that a map pays
for.

Sources: Foote, "tf: The Transform Library" (2013); Shoemake, "Animating Rotation with Quaternion Curves" (1985); REP
105 for the names of frames.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.se2 import wrap_angle

Floats = NDArray[np.float64]

NANOSECONDS = 1_000_000_000
#: As tf2 does by default: ten seconds.
CACHE_NS = 10 * NANOSECONDS
#: By how much the square of a quaternion's length may miss one, and the z axis of a pose of the plane.
UNIT_TOLERANCE, FLAT_TOLERANCE = 1e-3, 1e-6


class FrameError(InvalidArgumentError):
    """A transform that cannot be kept, or cannot be told; `argument` names what is at fault."""


class UnknownFrameError(FrameError):
    """A frame of which no transform was ever given: a name that is misspelt, or a node that does not run."""


class UnconnectedFramesError(FrameError):
    """Two frames that are in different trees: some link between them is published by nobody."""


class FrameLoopError(FrameError):
    """A transform that would make a frame its own ancestor."""


class FutureDateError(FrameError):
    """A date after the last transform: wait for it, and do not take another date instead."""


class PastDateError(FrameError):
    """A date before the first transform that is kept: never published, or too old for the cache."""


class TooOldError(FrameError):
    """A transform that arrives when the cache has moved on: its date is older than all that is kept."""


@dataclass(frozen=True, eq=False)
class Transform:
    """`translation` (3,), `rotation` (4,) = (x, y, z, w), brought to length one. Raises FrameError.

    A quaternion whose length is not one, to a thousandth, is a fault of who sent it: zeros are what a message holds
    that nobody filled.
    """

    translation: Floats
    rotation: Floats

    def __post_init__(self) -> None:
        for name, size in (("translation", 3), ("rotation", 4)):
            values = np.array(getattr(self, name), dtype=np.float64)
            if values.shape != (size,) or not np.all(np.isfinite(values)):
                raise FrameError(name, f"of shape {values.shape} is not an array ({size},) of finite numbers")
            object.__setattr__(self, name, values)
        square = float(self.rotation @ self.rotation)
        if abs(square - 1.0) > UNIT_TOLERANCE:
            raise FrameError("rotation", f"is a quaternion of length {np.sqrt(square):.4g}, not 1")
        object.__setattr__(self, "rotation", self.rotation / np.sqrt(square))

    @classmethod
    def from_planar(cls, pose: ArrayLike) -> Transform:
        """That of a pose (3,) = (x, y, theta) of the plane."""
        x, y, theta = np.asarray(pose, dtype=np.float64).tolist()
        return cls(np.array([x, y, 0.0]), np.array([0.0, 0.0, np.sin(theta / 2.0), np.cos(theta / 2.0)]))

    def to_planar(self) -> Floats:
        """The pose (3,) = (x, y, theta). Its height is dropped; a rotation that tilts raises FrameError."""
        qx, qy, qz, qw = self.rotation.tolist()
        if 2.0 * (qx * qx + qy * qy) > FLAT_TOLERANCE:
            raise FrameError("rotation", "tilts: it is no rotation of the plane")
        theta = wrap_angle(2.0 * float(np.arctan2(qz, qw)))
        return np.array([*self.translation[:2].tolist(), theta])

    def compose(self, T_b_c: Transform) -> Transform:
        """T_a_c, this one being T_a_b."""
        return Transform(
            self.translation + _rotate_vector(self.rotation, T_b_c.translation),
            _quaternion_product(self.rotation, T_b_c.rotation),
        )

    def inverse(self) -> Transform:
        back = self.rotation * [-1.0, -1.0, -1.0, 1.0]
        return Transform(-_rotate_vector(back, self.translation), back)


IDENTITY = Transform(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))


@dataclass(eq=False)
class _FrameLink:
    """How a frame is tied to its parent: the dates, increasing, and the transforms; none at all dated if `static`."""

    parent: str
    static: bool
    stamps: list[int] = field(default_factory=list)
    transforms: list[Transform] = field(default_factory=list)


class FrameBuffer:
    """Transforms as they arrive, kept for `cache_ns` nanoseconds behind the newest of each link."""

    def __init__(self, cache_ns: int = CACHE_NS) -> None:
        if cache_ns <= 0:
            raise FrameError("cache_ns", f"{cache_ns} keeps nothing")
        self.cache_ns = cache_ns
        self._links: dict[str, _FrameLink] = {}

    def add(
        self, parent: str, child: str, T_parent_child: Transform, stamp_ns: int = 0, *, static: bool = False
    ) -> None:
        """Take in the pose of `child` in `parent` at a date, or for ever if `static`: then its date is dropped.

        A second transform of the same date takes the place of the first. A child that comes with another parent changes
        trees, and its history begins anew. Raises FrameLoopError; TooOldError; FrameError for an empty name.
        """
        parent, child = _normalise_frame_name("parent", parent), _normalise_frame_name("child", child)
        if child in self._frames_to_root(parent):
            raise FrameLoopError("parent", f"{parent!r} descends from {child!r}, which cannot become its child")
        link = self._links.get(child)
        if link is None or link.parent != parent or link.static != static:
            link = self._links[child] = _FrameLink(parent, static)
        if static:
            link.stamps, link.transforms = [0], [T_parent_child]
            return
        if link.stamps and stamp_ns < link.stamps[-1] - self.cache_ns:
            late = (link.stamps[-1] - stamp_ns) / NANOSECONDS
            raise TooOldError(
                "stamp_ns",
                f"{parent} -> {child} arrives {late:.3f} s late, for a cache of {self.cache_ns / NANOSECONDS:g} s",
            )
        rank = bisect_left(link.stamps, stamp_ns)
        if rank < len(link.stamps) and link.stamps[rank] == stamp_ns:
            link.transforms[rank] = T_parent_child
            return
        link.stamps.insert(rank, stamp_ns)
        link.transforms.insert(rank, T_parent_child)
        forgotten = bisect_left(link.stamps, link.stamps[-1] - self.cache_ns)
        del link.stamps[:forgotten], link.transforms[:forgotten]

    def lookup(self, target: str, source: str, stamp_ns: int) -> Transform:
        """T_target_source at a date: it maps coordinates in `source` to coordinates in `target`.

        Raises UnknownFrameError, UnconnectedFramesError, FutureDateError, PastDateError.
        """
        up, down = self._frames_below_common_ancestor(target, source)
        T_ancestor_target, T_ancestor_source = self._compose_chain(up, stamp_ns), self._compose_chain(down, stamp_ns)
        return T_ancestor_target.inverse().compose(T_ancestor_source)

    def lookup_between(self, target: str, target_ns: int, source: str, source_ns: int, fixed: str) -> Transform:
        """Where `source` was at its date, seen from `target` at another, by way of a frame that did not move meanwhile.

        It brings the points of two scans, or of the first and last beam of one, into one frame. Errors are those of
        `lookup`.
        """
        return self.lookup(target, fixed, target_ns).compose(self.lookup(fixed, source, source_ns))

    def latest_common_stamp(self, target: str, source: str) -> int:
        """The last date (ns) at which `lookup` answers; 0 where all links between them are static. Errors as there."""
        up, down = self._frames_below_common_ancestor(target, source)
        ends = [self._links[frame].stamps[-1] for frame in up + down if not self._links[frame].static]
        return min(ends, default=0)

    def _frames_to_root(self, frame: str) -> list[str]:
        """A frame, its parent, and so on to the root. `add` lets no loop in."""
        found = [frame]
        while found[-1] in self._links:
            found.append(self._links[found[-1]].parent)
        return found

    def _frames_below_common_ancestor(self, target: str, source: str) -> tuple[list[str], list[str]]:
        """The frames below the nearest common ancestor, from the target up and from the source up."""
        target, source = _normalise_frame_name("target", target), _normalise_frame_name("source", source)
        known = set(self._links) | {link.parent for link in self._links.values()}
        for argument, name in (("target", target), ("source", source)):
            if name not in known:
                raise UnknownFrameError(
                    argument, f"{name!r} was never published; known: {', '.join(sorted(known)) or 'none'}"
                )
        up, down = self._frames_to_root(target), self._frames_to_root(source)
        if up[-1] != down[-1]:
            raise UnconnectedFramesError(
                "source",
                f"{source!r} hangs from {down[-1]!r}, {target!r} from {up[-1]!r}: nothing joins these two trees",
            )
        while up and down and up[-1] == down[-1]:
            up.pop()
            down.pop()
        return up, down

    def _compose_chain(self, frames: list[str], stamp_ns: int) -> Transform:
        """The pose of the first of the frames in the parent of the last, at a date."""
        T = IDENTITY
        for frame in frames:
            T = self._transform_at(frame, stamp_ns).compose(T)
        return T

    def _transform_at(self, child: str, stamp_ns: int) -> Transform:
        link = self._links[child]
        if link.static:
            return link.transforms[0]
        first, last = link.stamps[0], link.stamps[-1]
        if stamp_ns > last:
            late = (stamp_ns - last) / NANOSECONDS
            raise FutureDateError("stamp_ns", f"is {late:.6f} s after the last {link.parent} -> {child}")
        if stamp_ns < first:
            early = (first - stamp_ns) / NANOSECONDS
            raise PastDateError("stamp_ns", f"is {early:.6f} s before the first {link.parent} -> {child} that is kept")
        after = bisect_left(link.stamps, stamp_ns)
        if link.stamps[after] == stamp_ns:
            return link.transforms[after]
        share = (stamp_ns - link.stamps[after - 1]) / (link.stamps[after] - link.stamps[after - 1])
        return interpolate(link.transforms[after - 1], link.transforms[after], share)


def interpolate(first: Transform, last: Transform, share: float) -> Transform:
    """The transform a `share` of [0, 1] of the way from one to the other. Raises FrameError.

    slerp(p, q, u) = (sin((1 - u) a) p + sin(u a) q) / sin a,  cos a = p . q, taken positive                    (1)

    q and -q are one rotation: the sign that makes the arc the shorter one is taken.
    """
    if not 0.0 <= share <= 1.0:
        raise FrameError("share", f"{share} is not in [0, 1]")
    p, q = first.rotation, last.rotation
    cosine = float(p @ q)
    if cosine < 0.0:
        q, cosine = -q, -cosine
    angle = float(np.arctan2(np.linalg.norm(q - cosine * p), cosine))
    if angle < 1e-9:
        rotation = (1.0 - share) * p + share * q
    else:
        rotation = (np.sin((1.0 - share) * angle) * p + np.sin(share * angle) * q) / np.sin(angle)
    return Transform((1.0 - share) * first.translation + share * last.translation, rotation)


def _quaternion_product(p: Floats, q: Floats) -> Floats:
    """The quaternion of rotation q followed by p."""
    (px, py, pz, pw), (qx, qy, qz, qw) = p.tolist(), q.tolist()
    return np.array(
        [
            pw * qx + px * qw + py * qz - pz * qy,
            pw * qy - px * qz + py * qw + pz * qx,
            pw * qz + px * qy - py * qx + pz * qw,
            pw * qw - px * qx - py * qy - pz * qz,
        ]
    )


def _rotate_vector(q: Floats, v: Floats) -> Floats:
    """R(q) v = v + 2 u x (u x v + w v), u the vector part."""
    u, w = q[:3], q[3]
    return np.asarray(v + 2.0 * np.cross(u, np.cross(u, v) + w * v))


def _normalise_frame_name(argument: str, name: str) -> str:
    """A frame's name, without the slash that tf of ROS 1 put before it."""
    plain = name.removeprefix("/")
    if not plain:
        raise FrameError(argument, "is an empty name")
    return plain
