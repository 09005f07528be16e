"""What is promised of `covariance_jointe`, `covariance_relative` and `juger_fermeture`."""

from __future__ import annotations

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import TupleForm
from graders.core.compare.forms import NUMBER, POSE, WHOLE, NumberForm, WholeNumberForm, array

CONTRACTS = (
    FunctionContract(
        "covariance_jointe",
        {"H": array("3n", "3n"), "i": WHOLE, "j": WHOLE},
        array(6, 6),
        (
            Boundary("deux poses en tout", lambda H, i, j: len(H) == 6),
            Boundary("i = 0", lambda H, i, j: i == 0),
            Boundary("j = 0", lambda H, i, j: j == 0),
            Boundary("i > j", lambda H, i, j: i > j > 0),
            Boundary("i = j", free="ce n’est pas demandé"),
        ),
    ),
    FunctionContract(
        "covariance_relative",
        {"xi": POSE, "xj": POSE, "sigma": array(6, 6)},
        array(3, 3),
        (
            Boundary("une pose i connue exactement", lambda xi, xj, sigma: not sigma[:3].any()),
            Boundary(
                "un cap relatif d’un demi-tour",
                free="il n’est pas demandé, et des différences finies avec z = 0 passent",
            ),
            Boundary("deux poses qui se trompent ensemble", lambda xi, xj, sigma: sigma[0, 3] == sigma[0, 0] > 0.0),
        ),
    ),
    FunctionContract(
        "juger_fermeture",
        {"xi": POSE, "xj": POSE, "z": POSE, "sigma": array(6, 6), "omega": array(3, 3), "niveau": NUMBER},
        TupleForm(parts={"d²": NumberForm(), "accepte": WholeNumberForm(called="vrai ou faux")}),
        (
            Boundary("deux poses connues exactement", lambda xi, xj, z, sigma, omega, *niveau: not sigma.any()),
            Boundary("niveau omis", lambda *args: len(args) == 5),
            Boundary("une distance au seuil", free="elle en reste à plus de 1 %"),
            Boundary("le type de l’avis", free="True, 1 ou 1.0 ; False, 0 ou 0.0"),
        ),
    ),
)
