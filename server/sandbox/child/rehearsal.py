"""Rehearsal of a template before it serves, so that its forks find one-time work done.

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

from . import codec, course_calls, drawing, frames, inner, libc, orders
from .frames import QUESTION_LIMITS, pack_frame
from .kits import KitModules
from .namespaces import ForkNamespaces, write_files
from .program import Program
from .serve import ForkServer, sample_arguments, sample_calls, sample_configure, sample_load

#: Enough repetitions for the interpreter to specialise the code of a fork.
_REPETITIONS = 16
REHEARSAL_LIMITS = orders.ChildLimits(1000.0, 0, 0, 0, 0, 1, 1 << 16, 1 << 16, 8, 1000)
#: A sample of no exercise: a child knows nothing of a course, and every program can read this.
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


def warm_up(kits: Mapping[str, KitModules]) -> None:
    """Warm up, and leave nothing else behind: no name, no random number drawn, no timer, no descriptor."""
    with _restore_state_afterwards():
        for kit in kits:
            with suppress(Exception):  # a kit that fails does so again, and is told, when a submission asks for it
                Program(kits, _do_nothing).configure(kit, {"seed": 0})
        for _ in range(_REPETITIONS):
            _rehearse_fork_life(kits)
            _rehearse_course_call()
        np.random.default_rng(0).normal(size=3)
        _warm_linear_algebra()
        if drawing.is_loaded():
            drawing.warm_up()


@contextmanager
def _restore_state_afterwards() -> Iterator[None]:
    state, numpy_state = random.getstate(), np.random.get_state()
    streams = sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__
    try:
        yield
    finally:
        sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__ = streams  # type: ignore[misc]
        random.setstate(state)
        np.random.set_state(numpy_state)


def _rehearse_fork_life(kits: Mapping[str, KitModules]) -> None:
    """Go through the life of a fork, without its walls."""
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.sendall(_sample_questions())
        ours.shutdown(socket.SHUT_WR)
        ends, child = inner.ForkDescriptors(), ForkServer(kits, _do_nothing)
        ends.assign(*(theirs.fileno(), 1), *(theirs.fileno(),) * 3)
        child.set_limits(REHEARSAL_LIMITS)
        try:
            inner.ForkWalls(inner.prepare_descriptors(ends), (), (), _NoNamespaces(), (), os.getppid()).raise_walls(0)
            child.rehearse()
            child.send(0, frames.READY, b"")
            child.serve()
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
            for descriptor in (inner.WIRE, inner.TRACEBACK, inner.ASKS, inner.REPLIES):
                os.close(descriptor)
            child.unload()


def _rehearse_course_call() -> None:
    """Go through a call of a function of the course, on both sides."""
    question = course_calls.encode_call("cross", (np.array([1.0, 2.0, 0.5]), (1.0, 2.0, 3)), {})
    course_calls.read_reply(course_calls.answer_call(question, np, {"cross"}))


def _do_nothing() -> None:
    """Do nothing: there is no reserve to free."""


class _NoNamespaces(ForkNamespaces):
    """Stands for the namespaces of a fork: a rehearsal stays where the template is."""

    def __init__(self) -> None:
        super().__init__(0, libc.prepare_chdir("/"), folder=False, has_fork_hooks=False)

    def write_identity(self) -> None:
        write_files((("/dev/null", b"x"),) * 3, self.processes)


def _sample_questions() -> bytes:
    first, second = np.array([1.0, 2.0, 0.5]), np.array([3.0, 0.5, 1.0])
    columns = pack_frame(
        0, frames.COLUMNS, codec.encode((np.stack([first, second]), np.stack([second, first])), QUESTION_LIMITS)
    )
    batches = (
        sample_calls(
            "essai", 2, sample_arguments(first, second), sample_arguments(first, [1.0, 2.0, 3.0]), return_arguments=True
        ),
        sample_calls("essai", 2, columns),
        sample_calls("panne", 2, sample_arguments(first), sample_arguments(0.0)),
    )
    return pack_frame(1, frames.TOGETHER, b"".join((sample_configure(), sample_load(_SAMPLE), *batches)))


def _warm_linear_algebra() -> None:
    """The first call of a BLAS maps its working memory, which must count as the template's."""
    np.linalg.solve(np.eye(3), np.linalg.svd(np.eye(3))[0][0])
    np.eye(200) @ np.eye(200)
    if "scipy.linalg" in sys.modules:
        sys.modules["scipy.linalg"].solve(np.eye(3), np.ones(3))
        sparse = sys.modules["scipy.sparse"].csc_matrix(np.eye(3))
        sys.modules["scipy.sparse.linalg"].spsolve(sparse, np.ones(3))
