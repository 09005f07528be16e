"""What a template goes through before it serves, so that its forks find done what can be done once.

A fork that runs a line for the first time writes what the interpreter makes of it (specialised code, the places of
attributes, numbers of references) on pages that it shares with the template until then: each is copied, which takes
longer than most lines. Lines that the template has run often leave less to write.
"""

from __future__ import annotations

import os
import random
import signal
import socket
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress

import numpy as np

from . import codec, drawing, frames, inner, libc, orders
from .frames import QUESTION_LIMITS, framed
from .kits import Kit
from .namespaces import Nest, take
from .program import Program
from .serve import Child, calls, configuring, loading, row

#: The interpreter has then made of the code of a fork what it will stay.
_TIMES = 16
LIMITS = orders.Limits(1000.0, 0, 0, 0, 0, 1, 1 << 16, 1 << 16, 8, 1000)
#: What is rehearsed is no exercise's: a child knows nothing of a course, and every program can read this.
_SAMPLE = b"""
from __future__ import annotations
import numpy as np
def essai(u, v):
    p, q = np.exp(u[0]), np.tan(v[1])
    M = np.array([[p, q], [1.0, 2.0]])
    return np.concatenate([M @ np.asarray(v)[1:], [u[1] * v[0], np.cos(u[2])]])
def panne(u):
    raise ValueError("essai")
"""


def warm_up(kits: Mapping[str, Kit]) -> None:
    """Leaves nothing behind but what is warm: no name, no number drawn, no timer, no descriptor."""
    with _as_it_was():
        for kit in kits:
            with suppress(Exception):  # a kit that fails does so again, and is told, when a submission asks for it
                Program(kits, _nothing).configure(kit, {"seed": 0})
        for _ in range(_TIMES):
            _live(kits)
        np.random.default_rng(0).normal(size=3)
        _warm_linear_algebra()
        if drawing.offered():
            drawing.warm_up()


@contextmanager
def _as_it_was() -> Iterator[None]:
    state, numpy_state = random.getstate(), np.random.get_state()
    streams = sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__
    try:
        yield
    finally:
        sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__ = streams  # type: ignore[misc]
        random.setstate(state)
        np.random.set_state(numpy_state)


def _live(kits: Mapping[str, Kit]) -> None:
    """The life of a fork, without its walls."""
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.sendall(_questions())
        ours.shutdown(socket.SHUT_WR)
        ends, child = inner.Ends(), Child(kits, _nothing)
        ends.take(theirs.fileno(), 1, theirs.fileno())
        child.begin(LIMITS)
        try:
            inner.Walls(inner.connected(ends), (), (), _Ground(), (), os.getppid()).stand(0)
            child.rehearse()
            child.send(0, frames.READY, b"")
            child.serve()
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
            os.close(inner.WIRE)
            os.close(inner.WORDS)
            child.forget()


def _nothing() -> None:
    """There is no reserve to free."""


class _Ground(Nest):
    """Where a template stands already."""

    def __init__(self) -> None:
        super().__init__(0, libc.going("/"), folder=False, tells=False)

    def settle(self) -> None:
        take((("/dev/null", b"x"),) * 3, self.processes)


def _questions() -> bytes:
    one, two = np.array([1.0, 2.0, 0.5]), np.array([3.0, 0.5, 1.0])
    columns = framed(0, frames.COLUMNS, codec.encode((np.stack([one, two]), np.stack([two, one])), QUESTION_LIMITS))
    asked = (
        calls("essai", 2, row(one, two), row(one, [1.0, 2.0, 3.0]), keeping=True),
        calls("essai", 2, columns),
        calls("panne", 2, row(one), row(0.0)),
    )
    return framed(1, frames.TOGETHER, b"".join((configuring(), loading(_SAMPLE), *asked)))


def _warm_linear_algebra() -> None:
    """The first call of a BLAS maps its working memory, which must count as the template's."""
    np.linalg.solve(np.eye(3), np.linalg.svd(np.eye(3))[0][0])
    np.eye(200) @ np.eye(200)
    if "scipy.linalg" in sys.modules:
        sys.modules["scipy.linalg"].solve(np.eye(3), np.ones(3))
        sparse = sys.modules["scipy.sparse"].csc_matrix(np.eye(3))
        sys.modules["scipy.sparse.linalg"].spsolve(sparse, np.ones(3))
