"""What is promised of `predire` and `corriger` on a line."""

from __future__ import annotations

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import TupleForm
from graders.core.compare.forms import NUMBER, NumberForm

PAIR = TupleForm(parts={"moyenne": NumberForm(), "variance": NumberForm()})
CONTRACTS = (
    FunctionContract(
        "predire",
        {"m": NUMBER, "v": NUMBER, "u": NUMBER, "q": NUMBER},
        PAIR,
        (
            Boundary("q = 0", lambda m, v, u, q: q == 0.0),
            Boundary("u = 0", lambda m, v, u, q: u == 0.0),
            Boundary("une variance v nulle", free="elle n’est pas donnée"),
        ),
    ),
    FunctionContract(
        "corriger",
        {"m": NUMBER, "v": NUMBER, "z": NUMBER, "r": NUMBER},
        PAIR,
        (
            Boundary("un capteur aussi sûr que la croyance", lambda m, v, z, r: v == r),
            Boundary("une mesure égale à la moyenne", lambda m, v, z, r: m == z),
            Boundary("une variance nulle", free="elle n’est pas donnée"),
        ),
    ),
)
