"""Answers that are taken in together: a forger gets out of it what it would get if each were heard by itself."""

from __future__ import annotations

import socket
from copy import deepcopy
from types import SimpleNamespace
from unittest.mock import patch

import numpy as np
import pytest

from server.sandbox import CallBatch, ProgramFault, Reply, Session
from server.sandbox.answer_shape import AnswerShape
from server.sandbox.batch import Batch, BatchGroup
from server.sandbox.child import frames
from server.sandbox.child.codec import ValueLimits, encode
from server.sandbox.child.frames import pack_frame
from server.sandbox.process import ChildExit
from server.sandbox.wire import Wire

from .limits import only

LIMITS = ValueLimits(1 << 16, 8, 1000)
#: Tight ones: a stream of a few dozen answers comes near each.
POLICIES = [
    only(session_bytes=1 << 20),
    only(session_bytes=1200),
    only(items=1000, session_items=1000),
    only(frame_bytes=1 << 10),
]
SIZES = (1, 2, 3, 40, 200)


def answered(stream: bytes, parcel: BatchGroup, policy: object) -> list[object]:
    """All that a session gives of what came, and what is left of its budgets."""
    ours, theirs = socket.socketpair()
    child = SimpleNamespace(
        wire=Wire(ours),
        kill=lambda: None,
        wait_exit=lambda _: ChildExit(0, 0.0, 0),
        output=SimpleNamespace(crash_traceback=str),
    )
    with ours, theirs:
        theirs.sendall(stream)
        theirs.close()
        session = Session(child, policy)  # type: ignore[arg-type]
        session.functions = frozenset({"f"})
        session._register_group(parcel)
        # What came first is looked at last: nothing that has come since may have changed it.
        given = [(number, one) for number, answers in session._batch_answers(parcel, iter(())) for one in answers]
        told: list[object] = [(number, _shown(one)) for number, one in given]
        return [*told, session._bytes_left, session._items_left, child.wire.has_whole_answer]


def _shown(answer: Reply | ProgramFault) -> object:
    if isinstance(answer, ProgramFault):
        return answer.kind, answer.message, answer.fatal
    value = answer.value
    if isinstance(value, np.ndarray):
        assert all((value.flags.writeable, value.flags.c_contiguous, value.flags.aligned))
        return value.dtype.str, value.shape, value.tobytes()
    return repr(value), answer.arguments


def _parcel(rng: np.random.Generator) -> BatchGroup:
    parcel = BatchGroup([CallBatch("f", [(float(k),) for k in range(size)], 3) for size in rng.choice(SIZES, 2)], 0)
    parcel.payload(1.0)
    return parcel


def _values(rng: np.random.Generator) -> list[object]:
    odd = [-0.0, np.nan, 1, True, None, np.zeros(3, np.float32), np.zeros((3, 1)), np.zeros(0), np.arange(3), [1.0]]
    usual = [1.5, rng.normal(size=(300, 3)), np.full((300, 2, 3), -0.0), np.full((300, 3), np.nan)][rng.integers(4)]
    each = usual if isinstance(usual, np.ndarray) else [usual] * 300
    return [odd[rng.integers(len(odd))] if rng.random() < 0.04 else each[k] for k in range(max(SIZES))]


def _honest(batch: Batch, values: list[object]) -> list[bytes]:
    """Its frames, as an honest child would send them."""
    tokens = batch._tokens
    sent = [
        pack_frame(one, frames.VALUE, encode((value, None), LIMITS)) for one, value in zip(tokens, values, strict=False)
    ]
    return [*sent, pack_frame(batch.token, frames.DONE, b"")]


def _forged(sent: list[bytes], rng: np.random.Generator) -> bytes:
    """One frame out of its place, twice, lost, cut short, with other bytes, or none of these."""
    sent, at, other = list(sent), *(int(one) for one in rng.integers(0, len(sent), 2))
    kind = rng.integers(7)
    if kind == 0:
        sent[at], sent[other] = sent[other], sent[at]
    elif kind == 1:
        sent.insert(at, sent[other])
    elif kind == 2:
        del sent[at]
    elif kind == 3:
        sent[at] = sent[at][: rng.integers(len(sent[at]))]
    elif kind == 4:
        changed = bytearray(sent[at])
        changed[rng.integers(len(changed))] ^= 1 << int(rng.integers(8))
        sent[at] = bytes(changed)
    elif kind == 5:
        sent = sent[: at + 1]
    return b"".join(sent)


@pytest.mark.parametrize("policy", POLICIES)
def test_a_stream_of_frames_gives_the_same_whether_answers_are_taken_in_together_or_not(policy: object) -> None:
    rng, ends = np.random.default_rng(3), set()
    for _ in range(40):
        parcel = _parcel(rng)
        sent = [frame for _, batch in parcel.batches for frame in _honest(batch, _values(rng))]
        stream = _forged(sent, rng)
        together = answered(stream, deepcopy(parcel), policy)
        with patch.object(AnswerShape, "learn"):
            assert answered(stream, parcel, policy) == together
        *told, _, _, _ = together
        ends.add(str(told[-1]))
    assert any("INVALID_OUTPUT" in end for end in ends), "it was found out"
    assert not all("True)" in end for end in ends), "or got through"
