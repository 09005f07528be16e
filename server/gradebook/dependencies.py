"""What routes ask of the gradebook."""

from collections.abc import Callable
from typing import Annotated, Literal
from uuid import UUID

from fastapi import Depends, Form

from server.database.dependencies import Db
from server.gradebook import solutions
from server.identity.dependencies import SignedIn


def _door(
    account: SignedIn,
    db: Db,
    ouvrir: Annotated[bool, Form()],
    classe: Annotated[UUID | Literal[""], Form()] = "",
) -> Callable[[str], None]:
    def turn(solution: str) -> None:
        solutions.set_solution_open(db, account, solution, classe or None, wanted=ouvrir)

    return turn


#: What a form says of a solution, by its id: open or closed, to a class, or to everyone where none is named.
SolutionToggle = Annotated[Callable[[str], None], Depends(_door)]
