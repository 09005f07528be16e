"""l20/reechantillonnage: the effective number of particles, and the comb (course exercise 2)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graders.core.code.checks import Cases, Trial, Untouched
from graders.core.code.exercise import code
from graders.core.compare.comparison import ScalarCloseTo
from graders.core.contract.values import Arguments, Value
from graders.l20 import world
from graders.l20.reechantillonnage import trials
from graders.l20.reechantillonnage.contract import CONTRACTS
from graders.l20.reechantillonnage.harvest import FUNCTION
from graders.l20.reechantillonnage.probes import PROBES
from reference.filters.resampling import effective_sample_size


def simple_weights(rng: np.random.Generator) -> Iterator[Arguments]:
    """Equal weights, a single one, half of the particles.

    Ten equal weights do not make ten but for rounding: a result cut to a whole number fails there, whatever is drawn.
    """
    for weights in ([0.5, 0.5], [1.0, 0.0], [0.25] * 4, [0.0, 0.0, 1.0], [0.5, 0.5, 0.0, 0.0], [1.0], [0.1] * 10):
        yield (np.array(weights),)
    for n in rng.integers(5, 40, 3):
        yield (np.full(n, 1.0 / n),)
        yield (np.eye(n)[rng.integers(n)],)


def uneven_weights(rng: np.random.Generator) -> Iterator[Arguments]:
    """Weights between these two extremes, some of them zero, up to 500 particles."""
    yield (np.array([0.75, 0.25]),)
    yield (np.array([0.5, 0.25, 0.25]),)
    yield (np.array([0.1, 0.2, 0.3, 0.4]),)
    for n in (3, 6, 10, 60, 500):
        yield (trials.uneven_weights(rng, n),)
        weights = trials.uneven_weights(rng, n) * (rng.random(n) < 0.7)
        weights[0] += 0.1
        yield (weights / weights.sum(),)


def shrink_weights(value: Value) -> Iterator[Value]:
    """Fewer particles, then weights in whole tenths; always normalised."""
    weights = np.asarray(value, dtype=np.float64)
    for kept in (weights[: len(weights) // 2], weights[:-1], weights[1:]):
        if len(kept) and kept.sum() > 0:
            yield kept / kept.sum()
    tenths = np.round(weights, 1)
    tenths[0] += 1.0 - tenths.sum()
    if tenths[0] >= 0 and np.any(np.abs(20 * weights - np.round(20 * weights)) > 1e-9):
        yield np.round(tenths, 1)


CHECKS = (
    Cases(
        id="neff_extremes",
        title="N_eff : poids égaux, poids concentré",
        points=3,
        functions=("n_eff",),
        names=("poids",),
        cases=simple_weights,
        expected=effective_sample_size,
        compare=ScalarCloseTo(),
        shrinkers=(shrink_weights,),
        hint="Pour quatre poids égaux à 1/4, combien vaut la somme de leurs carrés ? Et que doit valoir N_eff ?",
    ),
    Cases(
        id="neff_hasard",
        title="N_eff : des poids quelconques",
        points=3,
        functions=("n_eff",),
        names=("poids",),
        cases=uneven_weights,
        expected=effective_sample_size,
        compare=ScalarCloseTo(),
        shrinkers=(shrink_weights,),
        hint="Pour les poids 3/4 et 1/4, calculez 1/Σwᵢ² à la main : trouvez-vous 1,6 ?",
    ),
    Trial(
        id="forme",
        title="Rééchantillonner : N particules, copiées parmi celles qui ont un poids",
        points=2,
        functions=(FUNCTION,),
        protocol=trials.right_shape,
        hint="Que contient particules[indices] quand indices est un tableau de N numéros ?",
    ),
    Trial(
        id="copies_exactes",
        title="Poids égaux : une copie de chacune ; poids concentré : N copies de la même",
        points=3,
        functions=(FUNCTION,),
        protocol=trials.exact_copies,
        hint="Tracez le segment [0, 1] découpé par les poids 1/2 et 1/2 : où tombent les deux dents du peigne ?",
    ),
    Trial(
        id="bornes",
        title="⌊N·w⌋ ou ⌈N·w⌉ copies de chaque particule",
        points=4,
        functions=(FUNCTION,),
        protocol=trials.bounded_copies,
        hint="Deux dents voisines sont-elles toujours séparées d'exactement 1/N ?",
    ),
    Trial(
        id="sans_biais",
        title="En moyenne, N·w copies de chaque particule",
        points=4,
        functions=(FUNCTION,),
        protocol=trials.unbiased,
        hint="Quelles positions la première dent peut-elle prendre, et change-t-elle d'un appel à l'autre ?",
    ),
    Untouched(
        id="arguments",
        title="Particules et poids restent intacts",
        points=1,
        functions=("n_eff", FUNCTION),
        names={"n_eff": ("poids",), FUNCTION: ("particules", "poids")},
        inputs=trials.arguments_to_keep,
        chance=(FUNCTION,),
        hint="Votre code écrit-il dans le tableau reçu, ou dans un nouveau tableau ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
