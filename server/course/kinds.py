"""The kinds of lessons: one table for their folders, the order in which one reads them, and their shelf.

A new kind is a new row.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LessonKind:
    """`folder` holds them, in the module's. `shelf` is their title on the module's page, none where they stand alone.

    `timed`: its authors say how long it takes, as for a paper; the length of other pages is measured.
    `numbered` says whose theorems and formulas are counted first: those of the sheets, which the others refer to.
    """

    name: str
    folder: str
    shelf: str
    numbered: int
    timed: bool = False


#: In the order of reading.
KINDS = (
    LessonKind("seance", "seances", "", 2),
    LessonKind("cours", "cours", "Cours", 3),
    LessonKind("fiche", "fiches", "Fiches", 1),
    LessonKind("tp", "tp", "Travaux pratiques", 4, timed=True),
    LessonKind("defi", "defis", "Défis", 5, timed=True),
    LessonKind("annexe", "annexes", "Annexes", 6),
    LessonKind("sujet", "sujets", "Sujets d’épreuve", 7, timed=True),
)
BY_FOLDER = {kind.folder: kind for kind in KINDS}
SEANCE = KINDS[0]
PAPER = BY_FOLDER["sujets"]
