"""What of a gradebook's page was drawn lately: the same for all who look at it until something changes, and found by
all that it is drawn from."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

from markupsafe import Markup

from server.base.caches import Lately
from server.desk.marks.schemas import GradebookWork
from server.marks.schemas import Gradebook
from server.web import school_time
from server.web.rendering import environment

KEPT_CHARACTERS = 4_000_000  # of HTML: eighty gradebooks of 35 students and five assignments

_KEPT: Lately[Hashable, Markup] = Lately(KEPT_CHARACTERS, size=len)


def work(book: Gradebook, path: str, asked: Hashable, view: Callable[[], GradebookWork]) -> Markup:
    """`view` of a whole book as it is `asked` for, at that address; dates are told on the school's clock."""
    key = (book.made, path, asked, school_time.zone().key)
    return _KEPT.get(key) or _KEPT.put(key, Markup(_macros().work(view())))


def _macros() -> Any:
    return environment().get_template("classes/gradebook_kept.html").module
