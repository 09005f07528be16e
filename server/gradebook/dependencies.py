"""Dependencies of routes that open or close solutions."""

from collections.abc import Callable
from typing import Annotated, Literal
from uuid import UUID

from fastapi import Depends, Form

from server.database.dependencies import Db
from server.gradebook import solutions
from server.identity.dependencies import SignedIn


def _make_solution_opener(
    account: SignedIn,
    db: Db,
    ouvrir: Annotated[bool, Form()],
    classe: Annotated[UUID | Literal[""], Form()] = "",
) -> Callable[[str], None]:
    def set_open(exercise: str) -> None:
        solutions.set_solution_open(db, account, exercise, classe or None, is_open=ouvrir)

    return set_open


#: Opens or closes the solution of an exercise as a form says: to a class, or to everyone where none is named.
SolutionToggle = Annotated[Callable[[str], None], Depends(_make_solution_opener)]
