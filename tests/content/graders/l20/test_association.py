"""l20/association: what is right is what the reference finds, nothing hangs on a tie, fixed cases catch mistakes."""

import json
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

from graders.core.contract.values import Arguments
from graders.l20.association import cases
from graders.l20.association.judge import SameAssociation
from graders.plotting import counterexample
from reference.data_association import ExpectedSightings, nearest_neighbours
from tests.support.quick import THEMES
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l20/association"
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)
IN_THE_ORDER_OF_THE_MAP, CUT_WHERE_EQUAL = (
    (CODE[EXERCISE].folder / f"specimens/wrong_answer/{name}.py").read_text(encoding="utf-8")
    for name in ("masque_dans_l_ordre_de_la_carte", "branches_egales_coupees")
)
NOISE = "M = C[np.ix_(lignes, lignes)] + np.kron(np.eye(len(paires)), R)"


def test_what_is_right_is_what_the_reference_finds() -> None:
    for shape in cases.JOINTS:
        z, landmarks, C, R, level = cases.joint_scan(*shape)
        expected, S = ExpectedSightings(landmarks, C, R, cases.NO_ANGLE), cases.alone(C, R)
        assert cases.right_distances(z, landmarks, S) == pytest.approx(expected.mahalanobis_distances(z))
        assert cases.right_nearest(z, landmarks, S, level) == nearest_neighbours(expected, z, level).landmarks.tolist()


def test_the_example_of_the_statement() -> None:
    z, landmarks, C, R = next(cases.joint_by_hand(np.random.default_rng(0)))
    S = cases.alone(C, R)
    assert cases.right_distances(z, landmarks, S) == pytest.approx(np.array([[3.12, 1.38], [20.3, 2.46]]), abs=0.05)
    assert cases.right_nearest(z, landmarks, S) == [1, -1]
    assert cases.right_new(z, landmarks, S) == []
    assert cases.right_joint(z, landmarks, C, R) == [0, 1]


def test_nothing_hangs_on_a_tie() -> None:
    rng = np.random.default_rng(1)
    assert all(map(cases.is_clear, (*cases.scans_by_hand(rng), *cases.any_scans(rng))))
    assert all(map(cases.decides, (*cases.joint_by_hand(rng), *cases.any_joints(rng))))


def test_cases_that_never_change_catch_each_known_mistake() -> None:
    """So that a mark does not depend on the seed."""
    rng = np.random.default_rng(1)
    fixed: dict[str, tuple[Callable[..., list[int]], list[Arguments]]] = {
        "associer": (cases.right_nearest, [*cases.scans_by_hand(rng), *(cases.steady_scan(*s) for s in cases.SCANS)]),
        "nouveaux": (cases.right_new, [*cases.scans_by_hand(rng), *(cases.steady_scan(*s) for s in cases.SCANS)]),
        "associer_ensemble": (
            cases.right_joint,
            [*cases.joint_by_hand(rng), *(cases.joint_scan(*s) for s in cases.JOINTS)],
        ),
    }
    prober = CODE[EXERCISE].prober
    assert prober is not None
    for edit in prober.model.edits:
        for function in edit.functions & fixed.keys():
            right, asked = fixed[function]
            names: dict[str, Any] = {"np": np}
            exec(edit.apply(prober.model.text) or "", names)
            assert any(_answer(names[function], args) != right(*args) for args in asked), edit.id


def _answer(function: Callable[..., Any], args: Arguments) -> object:
    try:
        return [int(k) for k in np.atleast_1d(function(*args))]
    except (ArithmeticError, LookupError, TypeError, ValueError, np.linalg.LinAlgError) as error:
        return type(error)


def test_an_association_is_compared_as_whole_numbers() -> None:
    same = SameAssociation()
    assert all(same([0, -1], got) is None for got in ([0, -1], (0.0, -1.0), np.array([0, -1])))
    assert all(same([0, -1], got) is not None for got in ([0], [0, 1], [0.5, -1], None, "0 -1", [[0, -1]]))


@pytest.mark.parametrize(
    ("source", "name", "checks"),
    [
        (edited(NOISE, "M = np.kron(np.eye(len(paires)), R)"), "commune_oubliee", {"ensemble_exemples"}),
        (IN_THE_ORDER_OF_THE_MAP, "ordre_de_c", {"ensemble_exemples"}),
        (CUT_WHERE_EQUAL, "premiere_trouvee", {"ensemble_exemples"}),
        (edited("np.flatnonzero(np.min(D, axis=1) > porte)", "np.flatnonzero(associer(z, amers, S, niveau) < 0)"),
         "non_associees", {"nouveaux_exemples", "nouveaux_quelconques"}),
        (edited("    return D\n\n\ndef associer(", "    z += 1.0\n    return D\n\n\ndef associer("),
         "argument_modifie", {"arguments"}),
    ],
)  # fmt: skip
def test_a_mistake_is_refused_and_named(source: str, name: str, checks: set[str]) -> None:
    found = verdict(source, 3)
    assert checks <= failed(found)
    assert named(found) == name


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    wrong = edited("choix[i] = k", "choix[i] = k + 1", NOISE, "M = np.kron(np.eye(len(paires)), R)")
    figures = json.loads(json.dumps(checked(EXERCISE, wrong, 1).figures))
    for check in ("proches_exemples", "ensemble_quelconques")[theme == "light" :]:  # both have one kind
        assert counterexample(EXERCISE, figures[check], theme=theme).startswith(b"<?xml")


@pytest.mark.parametrize("solved", ["np.linalg.pinv(M) @ h", "np.linalg.lstsq(M, h, rcond=None)[0]"])
def test_a_noise_in_every_block_is_named_however_a_singular_matrix_is_inverted(solved: str) -> None:
    blocks = "np.kron(np.eye(len(paires)), R)", "np.tile(R, (len(paires), len(paires)))"
    source = edited(*blocks, "np.linalg.solve(M, h)", solved)
    assert named(verdict(source, 3)) == "bruit_commun"
