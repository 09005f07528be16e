"""The error of a declaration that cannot be used."""

from __future__ import annotations


class MalformedDeclaration(Exception):
    """What is wrong, in French, and where: `place` is a path such as « verifications[0].cas[2] »."""

    def __init__(self, message: str, place: str = "") -> None:
        super().__init__(f"{place} : {message}" if place else message)
        self.message, self.place = message, place

    def below_place(self, place: str) -> MalformedDeclaration:
        """Return the same error below a place."""
        return MalformedDeclaration(self.message, f"{place}.{self.place}" if self.place else place)
