"""Copies of what programs exchange are those that `copy.deepcopy` makes."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import scipy.sparse as sp

from graders.core.contract.copies import copy_value
from tests.graders.core.test_answer_arrays import ANSWERS
from tests.support.tables import folded

VALUES: list[Any] = [
    *ANSWERS,
    np.asfortranarray(np.arange(6.0).reshape(2, 3)),
    np.arange(12)[::3],
    np.array([1, "deux", None], dtype=object),
    np.float64(1.5),
    np.matrix([[1.0, 2.0]]),
    b"octets",
    range(3),
    {"a": [np.arange(3), {"b": (1, [2.0])}]},
]


@folded("value", VALUES, ids=repr)
def test_it_is_the_same_and_of_the_same_types(value: Any) -> None:
    one, other = copy_value(value), copy.deepcopy(value)
    assert type(one) is type(other)
    assert repr(one) == repr(other)
    if isinstance(value, np.ndarray):
        assert not np.shares_memory(one, value)
        assert (one.dtype, one.strides, one.flags.writeable) == (other.dtype, other.strides, other.flags.writeable)


def test_what_is_written_on_a_copy_is_not_on_the_other() -> None:
    array, held = np.zeros(2), [1.0]
    value = ([array, held], {"a": held}, (array, 2), np.array([held, None], dtype=object), sp.eye(2, format="csr"))
    ours = copy_value(value)
    ours[0][0][0], ours[3][0][0], ours[4].data[0] = 1.0, 2.0, 3.0
    ours[0][1].append(2.0)
    ours[2][0][1] = 1.0
    assert (array.tolist(), held, value[3][0], value[4].data.tolist()) == ([0.0, 0.0], [1.0], [1.0], [1.0, 1.0])
    assert ours[1]["a"] == [1.0], "on the way to a student's program, what is there twice becomes two"


def test_a_list_that_holds_itself_is_copied_too() -> None:
    value: list[Any] = [1.0]
    value.append(value)
    ours = copy_value(value)
    assert ours is not value
    assert ours[1] is ours
