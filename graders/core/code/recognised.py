"""What the probes of a program recognise."""

from __future__ import annotations

from typing import NamedTuple


class SilentName(NamedTuple):
    """A mistake named on answers that tell little, and the number of the probes; for opinions the text of the mutant
    that answers alike, and the names that rules give `instead`."""

    mistake: str
    number: int
    text: str
    instead: tuple[str, ...]


class RecognisedMistakes(NamedTuple):
    """Ids of the mistakes found, in order; `fallback` ids, from the last rules, for when nothing else finds a name; and
    the functions whose wrong answers are `consequences` of mistakes in others. The mistakes are `certain` where every
    function answers as a mutant with these and no other does; `silent` are named on answers that tell little, of which
    the `likely` ones could not be verified in the program."""

    mistakes: tuple[str, ...] = ()
    fallback: tuple[str, ...] = ()
    consequences: tuple[str, ...] = ()
    certain: bool = False
    silent: tuple[SilentName, ...] = ()
    likely: tuple[str, ...] = ()
