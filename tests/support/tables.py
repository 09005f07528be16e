"""Tables of small cases: one test walks them all, as a test of its own costs more than such a case does."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from tests.support.quick import some

Test = Callable[..., None]


def folded(names: str | Sequence[str], cases: Iterable[Any], ids: object = None) -> Callable[[Test], Test]:
    """Run a test on each case, as `pytest.mark.parametrize` does, but as one test; all that fail are told.

    For cases that take milliseconds and change nothing that the next one sees: fixtures are made once. `ids` are not
    needed, as a failure shows its case.
    """
    keys = [name.strip() for name in names.split(",")] if isinstance(names, str) else [*names]
    table = [case if len(keys) > 1 else (case,) for case in some(cases)]

    def decorate(test: Test) -> Test:
        signature = inspect.signature(test)

        @functools.wraps(test)
        def run(**others: Any) -> None:
            failures = []
            for case in table:
                values = dict(zip(keys, case, strict=True))
                try:
                    test(**values, **others)
                except Exception as error:
                    error.add_note(f"case: {values!r:.500}")
                    failures.append(error)
            if failures:
                raise ExceptionGroup(f"{len(failures)} of {len(table)} cases fail", failures)

        left = [parameter for name, parameter in signature.parameters.items() if name not in keys]
        run.__signature__ = signature.replace(parameters=left)  # type: ignore[attr-defined]
        del run.__wrapped__
        return run

    return decorate
