"""Ce qui corrige __MODULE__/__SLUG__ : les nombres tirés pour chacun, et ce que l'on en attend."""

import numpy as np

from graders.core.answers.numeric import numeric
from graders.core.answers.quantity import Quantity


def deal(rng: np.random.Generator) -> dict[str, float]:
    """Les nombres d'un élève, par leurs noms de questions.toml."""
    a = int(rng.integers(1, 10))
    return {"a": float(a), "b": float(a + rng.integers(10, 30)), "t": int(rng.integers(10, 90)) / 100}


QUANTITIES = (
    Quantity(
        "point",
        20,  # les points de toutes font 20
        lambda data, earlier: data["a"] + data["t"] * (data["b"] - data["a"]),
        rel=0.002,
        abs=0.001,
        slips={"depart_oublie": lambda data, earlier: data["t"] * (data["b"] - data["a"])},
    ),
)

DEFINITION = numeric(__file__, deal=deal, quantities=QUANTITIES)
