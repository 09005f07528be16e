"""A table of cases that is one test tells all that fail."""

from __future__ import annotations

import pytest

from tests.support.tables import folded


@folded("divisor", [1, 2])
@folded(("number", "is_prime"), [(7, True), (8, False), (9, True)], ids=str)
def check_primes(number: int, is_prime: bool, divisor: int) -> None:
    assert all(number % factor for factor in range(2, number)) == is_prime or divisor == 1


def test_each_case_that_fails_is_told() -> None:
    with pytest.raises(ExceptionGroup, match="1 of 2 cases") as told:
        check_primes()
    (inner,) = told.value.exceptions
    assert isinstance(inner, ExceptionGroup)
    (failure,) = inner.exceptions
    assert failure.__notes__ == ["case: {'number': 9, 'is_prime': True}"]
    assert inner.__notes__ == ["case: {'divisor': 2}"]
