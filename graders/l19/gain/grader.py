"""l19/gain: how much a measurement is worth, several of them put together, and one after the other."""

from __future__ import annotations

from functools import partial

import numpy as np

from graders.core.code.checks import Cases, Untouched
from graders.core.code.exercise import code
from graders.core.compare.comparison import CloseTo, ScalarCloseTo
from graders.core.compare.shrinking import shrink_array, shrink_number
from graders.core.contract.values import Arguments, Floats
from graders.l19.gain import cases
from graders.l19.gain.contract import CONTRACTS
from graders.l19.gain.pictures import chain_figure, opinions_figure
from graders.l19.gain.probes import NAMES, PROBES
from graders.l19.pairs import SamePair
from graders.l19.truth import seen

GAIN, FUSE, CHAIN = ("gain",), ("fusionner",), ("enchainer",)
FUSED, CHAINED = ("mesures", "variances"), ("m", "v", "mesures", "variances")


def right_gain(v: float, r: float) -> float:
    """How far a reading at 1 draws a belief at 0."""
    return seen(0.0, v, 1.0, r)[0]


def right_chain(m: float, v: float, measured: Floats, variances: Floats) -> Floats:
    rows = []
    for z, r in zip(measured.tolist(), variances.tolist(), strict=True):
        m, v = seen(m, v, z, r)
        rows.append([m, v])
    return np.array(rows)


def right_fusion(measured: Floats, variances: Floats) -> tuple[float, float]:
    """The end of the chain that starts from the first measurement."""
    first = np.array([[measured[0], variances[0]]])
    rows = right_chain(float(measured[0]), float(variances[0]), measured[1:], variances[1:])
    mean, variance = np.concatenate([first, rows.reshape(-1, 2)])[-1].tolist()
    return mean, variance


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    return {"fusionner": next(cases.any_opinions(rng)), "enchainer": next(cases.any_chains(rng))}


Gains = partial(
    Cases,
    functions=GAIN,
    names=("v", "r"),
    expected=right_gain,
    compare=ScalarCloseTo(),
    shrinkers=(shrink_number, shrink_number),
)
Fusions = partial(
    Cases,
    functions=FUSE,
    names=FUSED,
    expected=right_fusion,
    compare=SamePair(NAMES),
    shrinkers=(shrink_array, shrink_array),
    valid=cases.are_opinions,
    figure=opinions_figure,
)
Chains = partial(
    Cases,
    functions=CHAIN,
    names=CHAINED,
    expected=right_chain,
    compare=CloseTo(),
    shrinkers=(shrink_number, shrink_number, shrink_array, shrink_array),
    valid=cases.is_chain,
    figure=chain_figure,
)

CHECKS = (
    Gains(
        id="gain",
        title="Le gain d'une mesure",
        points=3,
        cases=cases.gains_by_hand,
        valid=cases.are_gains,
        hint="Quand le capteur est bien meilleur que la croyance, le gain doit-il être près de 0 ou de 1 ?",
    ),
    Gains(
        id="gain_extremes",
        title="Un capteur parfait, une croyance sans aucun doute",
        points=2,
        cases=cases.gains_at_the_ends,
        valid=cases.are_ends,
        hint="Divisez-vous quelque part par v seul, ou par r seul ? Que se passe-t-il quand il est nul ?",
    ),
    Fusions(
        id="fusion_exemples",
        title="Fusionner deux mesures, trois, une seule",
        points=4,
        cases=cases.opinions_by_hand,
        hint="Laquelle des mesures doit peser le plus ? La variance du tout est-elle plus petite que la meilleure ?",
    ),
    Fusions(
        id="fusion_quelconques",
        title="Fusionner plus de mesures, des nombres quelconques",
        points=3,
        cases=cases.any_opinions,
        hint="Affichez vos poids : leur somme, une fois normalisés, vaut-elle 1 ? Toutes les mesures y sont-elles ?",
    ),
    Chains(
        id="chaine_exemples",
        title="Enchaîner les mesures, dont une parfaite",
        points=4,
        cases=cases.chains_by_hand,
        hint="À la deuxième mesure, d'où part la moyenne ? Avec quelle variance calculez-vous le gain ?",
    ),
    Chains(
        id="chaine_quelconques",
        title="Enchaîner plus de mesures, des nombres quelconques",
        points=3,
        cases=cases.any_chains,
        hint="La première ligne fausse : que valent m, v et le gain juste avant ?",
    ),
    Untouched(
        id="arguments",
        title="Les tableaux donnés restent intacts",
        points=1,
        functions=(*FUSE, *CHAIN),
        names={"fusionner": FUSED, "enchainer": CHAINED},
        inputs=arguments_to_keep,
        hint="L'écriture variances /= … crée-t-elle un nouveau tableau, ou change-t-elle celui qui est donné ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, probes=PROBES)
