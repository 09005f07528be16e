"""The trial of what `pas_mcl` keeps from one step to the next: in the hall, where one knows what a scan can teach."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.contract.values import Floats
from graders.l20.mcl.answers import STEP, stepped
from graders.l20.mcl.scenes import ALWAYS, HALL, HALL_RANGE, Step, hall, hall_kit, in_the_hall, judged, scan_of, step
from graders.l20.mcl.telling import cloud_figure, number, observed
from reference.filters.resampling import effective_sample_size
from reference.se2 import compose

HALF = 200
SURVIVES, FORGETS, UNEVEN, WINS = 0.03, 0.15, 0.3, 0.5
#: Between two clouds of the hall; and the weight of the left one beyond which its seven tenths have counted twice.
MIDDLE, TWICE = 18.5, 0.94

TWINS = ((13.0, 4.0, 0.0), (24.0, 4.0, 0.0))


@cache
def twins() -> tuple[Step, ...]:
    """Two clouds along the hall, which see the same wall."""
    rng = np.random.default_rng(ALWAYS)
    return tuple(step(rng, [(TWINS[k], HALF), (TWINS[1 - k], HALF)], (0.4, 0.0, 0.1), in_hall=True) for k in (0, 1))


@cache
def favourites() -> tuple[Step, ...]:
    """The same two clouds: 60 particles have seven tenths of the weight, 340 the rest."""
    rng = np.random.default_rng(ALWAYS)
    groups = [(TWINS[0], 60), (TWINS[1], 340)]
    return (step(rng, groups, (0.4, 0.0, 0.1), in_hall=True, weights=(0.7, 0.3)),)


@cache
def lesson() -> tuple[Step, Floats, Floats]:
    """A scan that tells two clouds apart, 280 particles and 120; then a move and a scan which do not."""
    rng = np.random.default_rng(ALWAYS)
    first = step(rng, [((16.0, 4.0, 0.0), 280), ((2.2, 4.0, 0.0), 120)], (0.2, 0.0, 0.0), in_hall=True)
    move = np.array([7.0, 0.0, 0.0])
    return first, move, scan_of(hall(), compose(first.truth, move), HALL_RANGE, rng)


@cache
def few() -> Step:
    """Forty particles near the robot, 360 where the scan is impossible."""
    rng = np.random.default_rng(ALWAYS)
    return step(rng, [((18.0, 4.0, 0.0), 40), ((2.2, 4.0, 0.0), 360)], (0.3, 0.0, 0.0), in_hall=True)


@observed(STEP)
def remembered(bench: Bench) -> None:
    """What scans cannot tell apart survives, what one has taught is not forgotten, and nothing counts twice."""
    with in_the_hall(bench) as hall:
        judges: tuple[Callable[[Bench], None], ...] = (
            *(partial(_both_survive, scene=scene) for scene in twins()),
            *(partial(_as_likely_as_before, scene=scene) for scene in favourites()),
            _nothing_forgotten,
            _nothing_twice,
        )
        for judge in judges:
            judged(hall, judge, hall_kit)


def _both_survive(bench: Bench, scene: Step) -> None:
    particles, weights = stepped(bench, scene.inputs)
    left = float(weights[particles[:, 0] < MIDDLE].sum())
    if min(left, 1.0 - left) < SURVIVES:
        raise Rejection(
            "Deux nuages de 200 particules expliquent aussi bien le scan l'un que l'autre. Après un seul pas, l'un des "
            f"deux a disparu : l'autre a {number(100 * max(left, 1 - left))} % du poids. Un scan qui ne "
            "départage pas deux hypothèses doit laisser vivre les deux.",
            inputs=scene.inputs,
            expected="à peu près la moitié du poids pour chacun",
            got=f"{number(100 * left)} % à gauche, {number(100 - 100 * left)} % à droite",
            figure=cloud_figure(HALL, scene, particles, "Deux nuages que rien ne distingue", weights=weights),
        )


def _as_likely_as_before(bench: Bench, scene: Step) -> None:
    """Only what counts the weights twice, or keeps the best alone, is refused: some filters have equal ones given."""
    particles, weights = stepped(bench, scene.inputs)
    left = float(weights[particles[:, 0] < MIDDLE].sum())
    if left > TWICE:
        raise Rejection(
            "Deux nuages expliquent aussi bien le scan l'un que l'autre, et les poids donnés en mettent 70 % à gauche, "
            f"30 % à droite. Après un pas, celui de gauche a {number(100 * left)} % du poids. Le "
            "rééchantillonnage copie chaque particule à proportion de son poids, et une copie pèse ensuite 1/N "
            ": ni plus, ni moins.",
            inputs=scene.inputs,
            expected="à peu près 70 % du poids à gauche",
            got=f"{number(100 * left)} %",
            figure=cloud_figure(HALL, scene, particles, "Deux nuages que rien ne distingue", weights=weights),
        )


def _nothing_forgotten(bench: Bench) -> None:
    first, move, scan = lesson()
    particles, weights = stepped(bench, first.inputs)
    learned = float(weights[particles[:, 0] > 12.0].sum())
    after = {"particules": particles, "poids": weights, "u": move, "scan": scan}
    later, new = stepped(bench, after)
    kept = float(new[later[:, 0] > 12.0].sum())
    if kept < learned - FORGETS:
        raise Rejection(
            f"Un premier scan donne {number(100 * learned)} % du poids au nuage de droite. Le scan suivant ne "
            f"départage pas les deux nuages, et pourtant celui de droite n'a plus que {number(100 * kept)} % : "
            "ce que le "
            "premier avait appris est oublié. Le nouveau poids est l'ancien, multiplié par la vraisemblance.",
            inputs=after,
            expected=f"toujours {number(100 * learned)} % environ",
            got=f"{number(100 * kept)} %",
            figure=cloud_figure(HALL, replace(first, particles=particles), later, "Après le second scan", weights=new),
        )


def _nothing_twice(bench: Bench) -> None:
    scene = few()
    particles, weights = stepped(bench, scene.inputs)
    is_near = particles[:, 0] > 9.0
    there, share = float(np.mean(is_near)), float(weights[is_near].sum())
    if share < WINS:
        raise Rejection(
            "Le scan n'est possible que pour 40 particules sur 400. Après un pas, elles et leurs copies n'ont que "
            f"{number(100 * share)} % du poids. Une particule que le scan rend impossible ne pèse plus rien ; si l'on "
            "rééchantillonne, chacune est copiée à proportion de son poids, autant de fois qu'il le faut.",
            inputs=scene.inputs,
            expected="presque tout le poids",
            got=f"{number(100 * share)} %",
            figure=cloud_figure(HALL, scene, particles, "Le nuage que le scan désigne", weights=weights),
        )
    useful = effective_sample_size(weights) / len(weights)
    if there > 0.5 and useful < UNEVEN:
        raise Rejection(
            "40 particules sur 400 expliquent le scan : votre fonction les recopie, et c'est bien. Mais les "
            f"poids rendus restent très inégaux (N_eff = {number(useful * len(weights))} pour {len(weights)} "
            "particules) : "
            "l'information compterait deux fois, par les copies et par les poids. Après un rééchantillonnage, "
            "chaque copie pèse 1/N.",
            inputs=scene.inputs,
            expected=f"des poids égaux, 1/{len(weights)}",
            got=weights,
            figure=cloud_figure(HALL, scene, particles, "Après un rééchantillonnage", weights=weights),
        )
