"""What is promised of `gain`, `fusionner` and `enchainer`."""

from __future__ import annotations

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import TupleForm
from graders.core.compare.forms import NUMBER, NumberForm, array

CONTRACTS = (
    FunctionContract(
        "gain",
        {"v": NUMBER, "r": NUMBER},
        NUMBER,
        (
            Boundary("un capteur parfait, r = 0", lambda v, r: r == 0.0),
            Boundary("une croyance sans doute, v = 0", lambda v, r: v == 0.0),
            Boundary("v = r", lambda v, r: v == r),
            Boundary("v = r = 0", free="ce n’est pas demandé"),
        ),
    ),
    FunctionContract(
        "fusionner",
        {"mesures": array("n"), "variances": array("n")},
        TupleForm(parts={"moyenne": NumberForm(), "variance": NumberForm()}),
        (
            Boundary("une seule mesure", lambda z, r: len(z) == 1),
            Boundary("des variances égales", lambda z, r: len(z) > 1 and len(set(r.tolist())) == 1),
            Boundary("une variance nulle, aucune mesure", free="elles ne sont pas données"),
        ),
    ),
    FunctionContract(
        "enchainer",
        {"m": NUMBER, "v": NUMBER, "mesures": array("n"), "variances": array("n")},
        array("n", 2),
        (
            Boundary("une seule mesure", lambda m, v, z, r: len(z) == 1),
            Boundary("une mesure parfaite", lambda m, v, z, r: 0.0 in r.tolist()),
            Boundary("deux mesures parfaites, v = 0 au départ", free="ce n’est pas demandé"),
        ),
    ),
)
