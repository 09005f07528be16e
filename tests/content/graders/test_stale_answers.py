"""A memory of results whose key leaves an argument out is refused and named; one with the whole key passes."""

from __future__ import annotations

import numpy as np
import pytest

from graders.core.code.stale_answers import make_changed_calls
from graders.core.contract.local import LOCAL
from tests.support.shipped import CODE

REMEMBERED = """

import copy, pickle
_juste, _deja = {function}, {{}}

def {function}({parameters}):
    cle = pickle.dumps([{key}])
    if cle not in _deja:
        _deja[cle] = _juste({arguments})
    return copy.deepcopy(_deja[cle])
"""

GAPS = (
    ("l19/matrice", "corriger", "x, P, z, H, R", "P, z, H, R"),
    ("l19/gain", "fusionner", "mesures, variances", "mesures"),
    ("l19/predire_corriger", "predire", "m, v, u, q", "m, v, u"),
    ("l20/fermeture", "covariance_jointe", "H, i, j", "H, i"),
    ("l20/odometrie", "sigma_dtheta", "sigma_g, sigma_d, L", "sigma_g, sigma_d"),
    ("l20/association", "nouveaux", "z, amers, S, niveau=0.99", "z, S, niveau"),
    ("l20/predire2d", "predire2d", "bel, du, dv", "bel, du"),
    ("l20/tf_date", "a_la_date", "dates, poses, date", "poses, date"),
    ("l20/lidar", "lancer_rayon", "libres, x, y, angle, portee_max", "x, y, angle, portee_max"),
)


def remembering(exercise: str, function: str, parameters: str, key: str) -> bytes:
    arguments = parameters.replace("=0.99", "")
    added = REMEMBERED.format(function=function, parameters=parameters, arguments=arguments, key=key)
    return (CODE[exercise].solution + added).encode()


@pytest.mark.parametrize(("exercise", "function", "parameters", "key"), GAPS)
def test_a_key_without_an_argument_is_refused_and_named(
    exercise: str, function: str, parameters: str, key: str
) -> None:
    verdict = CODE[exercise].grade(remembering(exercise, function, parameters, key), LOCAL, seed=3, version="v").verdict
    assert verdict.points < verdict.max_points
    assert verdict.diagnosis is not None
    assert verdict.diagnosis.id == "memoire"


@pytest.mark.parametrize("gap", GAPS[:2])
def test_a_whole_key_passes(gap: tuple[str, str, str, str]) -> None:
    exercise, function, parameters, _ = gap
    source = remembering(exercise, function, parameters, parameters)
    verdict = CODE[exercise].grade(source, LOCAL, seed=3, version="v").verdict
    assert verdict.points == verdict.max_points


def test_each_call_changes_one_argument_of_its_base() -> None:
    calls = [(np.eye(2), 3, [(0, 1)], "a"), (2.0 * np.eye(2), 4, [(0, 2)], "b"), (np.eye(2), 3)]
    series = make_changed_calls(calls)
    bases = [changed for k, changed in enumerate(series) if changed.base == k]
    assert [changed.args for changed in bases] == calls[:2]
    assert {changed.index for changed in series if changed.base == 0} == {0, 1, 2, 3}
    for changed in series:
        base = series[changed.base].args
        same = [np.array_equal(now, old) for now, old in zip(changed.args, base, strict=True)]
        assert same.count(False) == (changed is not series[changed.base])
        assert changed is series[changed.base] or not same[changed.index]
