"""Judging the copies that came out: between floor and ceil in each call, unbiased over many calls.

The comb shifts all its teeth by one uniform draw, so that a particle of expected copies N w = k + f, 0 < f < 1, gets
k + 1 copies with probability f and k with probability 1 - f, independently from call to call. Over T calls its copies
beyond k T are Binomial(T, f), whatever the order in which the particles are laid: the test on them is exact.

False alarms. Each particle of a statistical scenario is tested on both sides at TAIL = 1e-10: with 12 particles in
all, a right function is rejected with probability below 2 * 12 * 1e-10 = 2.4e-9. Where counts must be exact (N w whole)
or within floor and ceil, a right function fails only if its draw falls within rounding, about 1e-14, of a boundary.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from graders.core.code.checks import Rejection
from graders.core.compare import words as render
from graders.core.contract.findings import FigureData
from graders.core.contract.values import Floats
from graders.l20.reechantillonnage.harvest import FUNCTION, Counts, Harvest, Objection, Scenario
from reference.filters.resampling import comb_resampling

TAIL = 1e-10
SHOWN = 24


def out_of_bounds(harvest: Harvest) -> Objection | None:
    """The first call in which a particle has fewer than floor(N w) or more than ceil(N w) copies."""
    scenario, copies = harvest.scenario, harvest.copies
    below, above = copies < scenario.low, copies > scenario.high
    if not np.any(below | above):
        return None
    call, i = (int(k) for k in np.argwhere(below | above)[0])
    label = ("-" if np.any(below) else "") + ("+" if np.any(above) else "")
    return Objection(label, _bounds_rejection(scenario, copies[call], i))


def inexact(harvest: Harvest) -> Objection | None:
    """As `out_of_bounds`, where every N w is whole; known by the wrong copies when they are always the same."""
    objection = out_of_bounds(harvest)
    if objection is None:
        return None
    label = _always(harvest) if harvest.constant else "variable"
    return Objection(label, objection.rejection)


def weightless_copied(harvest: Harvest) -> Objection | None:
    """A particle of zero weight that was copied."""
    scenario = harvest.scenario
    wrong = (harvest.copies > 0) & (scenario.weights == 0.0)
    if not np.any(wrong):
        return None
    call, i = (int(k) for k in np.argwhere(wrong)[0])
    return Objection("poids nul copié", _bounds_rejection(scenario, harvest.copies[call], i))


def _bounds_rejection(scenario: Scenario, copies: Counts, i: int) -> Rejection:
    n = min(scenario.size, SHOWN)
    more = " ; …" if scenario.size > n else ""
    return Rejection(
        f"{_duty(scenario, i)}, et {FUNCTION} en donne {copies[i]}.",
        inputs=scenario.inputs,
        expected="copies de chaque particule : " + " ; ".join(_range_text(scenario, k) for k in range(n)) + more,
        got="copies de chaque particule : " + " ; ".join(str(k) for k in copies[:n]) + more,
        figure=comb_figure(scenario, copies, i, "vos copies"),
    )


def _duty(scenario: Scenario, i: int) -> str:
    if scenario.weights[i] == 0.0:
        return f"La particule {i} a un poids nul : il n'en faut aucune copie"
    weight, share = (render.number(float(x[i]), 4) for x in (scenario.weights, scenario.shares))
    wanted = copies_text(int(scenario.high[i]), _range_text(scenario, i))
    return f"La particule {i} a le poids {weight}, donc N·w = {share} : il en faut {wanted}"


def _range_text(scenario: Scenario, i: int) -> str:
    low, high = int(scenario.low[i]), int(scenario.high[i])
    return str(low) if low == high else f"{low} ou {high}"


def copies_text(most: int, number: str | None = None) -> str:
    """« 1 copie », « 2 copies » ; « 0 ou 1 copie » when `number` says more than `most`."""
    return f"{number or most} copie" + ("s" if most > 1 else "")


def bias(harvest: Harvest) -> Objection | None:
    """The particles copied too often or too seldom over all the calls, by exact binomial tests."""
    scenario, copies = harvest.scenario, harvest.copies
    total = copies.sum(axis=0)
    few, many = np.array([_acceptance(harvest, i) for i in range(scenario.size)]).T
    wrong = (total < few) | (total > many)
    if not np.any(wrong):
        return None
    expected = len(copies) * scenario.shares
    i = int(np.argmax(np.where(wrong, np.abs(total / expected - 1.0), -1.0)))
    return Objection(_bias_label(harvest, total, few, many), _bias_rejection(harvest, total, i))


def _acceptance(harvest: Harvest, i: int) -> tuple[int, int]:
    """How many copies of particle i in all are plausible for an unbiased function.

    Beyond a first violation of floor and ceil the function is no comb: it is then held to the wider spread of
    independent draws, N a call, each with probability w, so that what is unbiased is not called biased.
    """
    scenario, calls = harvest.scenario, len(harvest.copies)
    low, share = int(scenario.low[i]), float(scenario.shares[i])
    if np.all((harvest.copies >= scenario.low) & (harvest.copies <= scenario.high)):
        fewest, most = plausible(calls, round(min(max(share - low, 0.0), 1.0), 12))
        return calls * low + fewest, calls * low + most
    return plausible(calls * scenario.size, round(float(scenario.weights[i]), 12))


@cache
def plausible(n: int, p: float) -> tuple[int, int]:
    """The range (a, b) with P(X < a) <= TAIL and P(X > b) <= TAIL for X ~ Binomial(n, p)."""
    if p in (0.0, 1.0):
        return (round(n * p), round(n * p))
    k = np.arange(n + 1)
    logs = np.array([math.lgamma(n + 1) - math.lgamma(j + 1) - math.lgamma(n - j + 1) for j in range(n + 1)])
    mass = np.exp(logs + k * math.log(p) + (n - k) * math.log1p(-p))
    few = int(np.searchsorted(np.cumsum(mass), TAIL, side="right"))
    many = n - int(np.searchsorted(np.cumsum(mass[::-1]), TAIL, side="right"))
    return few, many


def _bias_label(harvest: Harvest, total: Counts, few: Counts, many: Counts) -> str:
    if not harvest.constant:
        signs = np.select([total < few, total > many], ["-", "+"], default="0")
        return f"biais {''.join(signs.tolist())}"
    first = harvest.copies[0]
    return "peigne figé" if is_comb(harvest.scenario.weights, first) else _always(harvest)


def is_comb(weights: Floats, copies: Counts) -> bool:
    """Are these the copies that a comb gives at some offset?"""
    breaks = np.unique(np.concatenate([[0.0, 1.0], np.mod(len(weights) * np.cumsum(weights), 1.0)]))
    middles = (breaks[1:] + breaks[:-1]) / 2
    return any(np.array_equal(comb_resampling(weights, float(u)).copies, copies) for u in middles)


def _bias_rejection(harvest: Harvest, total: Counts, i: int) -> Rejection:
    scenario, calls = harvest.scenario, len(harvest.copies)
    share = render.number(float(scenario.shares[i]), 4)
    about = round(calls * float(scenario.shares[i]))
    message = (
        f"Sur {calls} appels avec les mêmes poids, la particule {i} reçoit {copies_text(int(total[i]))} ; "
        f"on en attend environ {about} (N·w = {share} par appel)."
    )
    if harvest.constant:
        message += " Tous les appels donnent les mêmes copies : le hasard ne joue pas."
    message += " La moyenne pondérée du nuage n'est donc pas conservée."
    return Rejection(
        message,
        inputs={**scenario.inputs, "appels": calls},
        expected=_means_text(scenario.shares),
        got=_means_text(total / calls),
        figure=comb_figure(scenario, total / calls, i, f"vos copies, moyenne de {calls} appels"),
    )


def _means_text(means: Floats) -> str:
    return "copies par appel, en moyenne : " + " ; ".join(render.number(float(m), 3) for m in means)


def _always(harvest: Harvest) -> str:
    """The copies that every call gives, whichever of equal weights they fall on."""
    pairs = zip(harvest.scenario.weights, harvest.copies[0], strict=True)
    return "toujours " + " ; ".join(f"{n} de poids {w:.4f}" for w, n in sorted(pairs, reverse=True) if n)


def comb_figure(scenario: Scenario, obtained: Counts | Floats, i: int, legend: str) -> FigureData:
    """Data of a drawing of at most SHOWN particles around particle i; `legend` says what was obtained."""
    start = min(max(0, i - SHOWN // 2), max(0, scenario.size - SHOWN))
    part = slice(start, start + SHOWN)
    ends = np.cumsum(scenario.weights)
    return {
        "kind": "comb",
        "legend": legend,
        "first": start,
        "total": scenario.size,
        "ends": np.concatenate([[ends[start - 1] if start else 0.0], ends[part]]).tolist(),
        "shares": scenario.shares[part].tolist(),
        "low": scenario.low[part].tolist(),
        "high": scenario.high[part].tolist(),
        "got": np.asarray(obtained, dtype=np.float64)[part].tolist(),
    }
