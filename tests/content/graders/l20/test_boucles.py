"""l20/boucles: any honest descriptor and distance passes, every catalogued mistake is named, figures draw."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graders.core.contract.outcomes import Outcome
from graders.l20.boucles.readings import Unsuitable, read_signature
from graders.plotting import counterexample
from server.base.files import ROOT as PROJECT
from tests.content.graders.l20.boucles_styles import ARRAY, DESCRIPTORS, DISTANCES, LIST, submission
from tests.support.quick import THEMES, one_in, some
from tests.support.shipped import CODE
from tests.support.verdicts import checked, checked_verdict_of, failed, named, verdict_of

GRADER = CODE["l20/boucles"]
verdict = partial(verdict_of, GRADER.exercise)
checked_verdict = partial(checked_verdict_of, GRADER.exercise)
checks_of = partial(checked, GRADER.exercise)

SEEDS = range(12)


def mistake(name: str) -> Any:
    return next(m for m in GRADER.misconceptions if m.id == name)


@pytest.mark.parametrize("seed", range(3))
def test_the_solution_gets_full_marks(seed: int) -> None:
    assert verdict(GRADER.solution, seed).outcome is Outcome.OK


def test_the_starter_earns_nothing() -> None:
    starter = (PROJECT / "curriculum/l20/exercices/boucles/starter.py").read_text(encoding="utf-8")
    found = verdict(starter, 1)
    assert found.score == 0.0
    assert found.diagnosis is None


@pytest.mark.parametrize("name", one_in(8, DESCRIPTORS))
def test_every_honest_descriptor_passes(name: str) -> None:
    """Distances, styles and seeds taken in turn over the descriptors; see the grader for the thorough runs."""
    rank = list(DESCRIPTORS).index(name)
    distances = list(DISTANCES.values())
    seed, distance = SEEDS[5 * rank % len(SEEDS)], distances[4 * rank % len(distances)]
    found = verdict(submission(DESCRIPTORS[name], distance, (LIST, ARRAY)[rank % 2]), seed)
    assert found.outcome is Outcome.OK, (seed, distance, [(c.id, c.message) for c in found.checks if not c.passed])


@pytest.mark.parametrize(
    ("descriptor", "where"),
    [
        ("np.array([np.mean(scan)])", "sosies"),
        ("np.array([np.sum(scan), 36 * np.mean(scan)])", "sosies"),
        ("np.array([np.std(scan)])", "sosies"),
        ("np.array([np.var(scan)])", "sosies"),
        ("np.array([np.max(scan)])", "sosies"),
        ("np.array([np.min(scan)])", "sosies"),
        ("np.array([np.median(scan)])", "sosies"),
        ("np.array([np.sum(scan**2)])", "sosies"),
        ("np.array([np.ptp(scan)])", "sosies"),
        ("np.array([np.abs(np.fft.rfft(scan))[1]])", "sosies"),
        ("np.array([1.0, 2.0])", "signature_exemple"),
        ("np.array([len(scan)])", "signature_exemple"),
        ("np.histogram(scan, bins=1, range=(0, 12))[0]", "signature_exemple"),
        ("scan", "signature_rotation"),
        ("scan - scan.mean()", "signature_rotation"),
        ("scan / scan.max()", "signature_rotation"),
        ("np.diff(scan)", "signature_rotation"),
        ("np.cumsum(scan)", "signature_rotation"),
        ("scan[::-1]", "signature_rotation"),
        ("np.abs(np.fft.fft(scan[:35]))", "signature_rotation"),
        ("np.abs(np.fft.fft(np.append(scan, np.zeros(28))))", "signature_rotation"),
        ("np.fft.rfft(scan)", "signature_rotation"),
        ("np.abs(np.fft.rfft(scan).real)", "signature_rotation"),
        ("np.fft.rfft(scan).imag", "signature_rotation"),
        ("np.angle(np.fft.rfft(scan))", "signature_rotation"),
        ("np.abs(np.fft.fft(scan)) + 1e-3 * scan", "signature_rotation"),
        ("np.sort(scan[:18])", "signature_rotation"),
        ("np.array([scan[0]])", "signature_rotation"),
        ("np.histogram(scan, bins=10, weights=np.arange(36))[0]", "signature_rotation"),
        ("np.array([np.mean(scan), np.argmax(scan)])", "signature_rotation"),
        ("np.correlate(scan, scan, 'full')", "signature_rotation"),
        ("np.sort(scan) * np.nan", "signature_rotation"),
    ],
)
def test_poor_descriptors_are_rejected(descriptor: str, where: str) -> None:
    found = checked_verdict(submission(descriptor), 0)
    assert found.outcome is Outcome.WRONG_ANSWER
    assert where in failed(found)


def test_single_numbers_are_always_caught() -> None:
    for seed in range(2):
        assert failed(checked_verdict(mistake("moyenne_seule").source, seed)) == {"sosies"}
        assert "sosies" in failed(checked_verdict(submission("np.array([np.median(scan)])"), seed))


@pytest.mark.parametrize(
    ("body", "where"),
    [
        (LIST.replace("j <= i - 10", "j < i - 10"), "fenetre"),
        (LIST.replace("j <= i - 10", "j <= i - 9"), "fenetre"),
        (LIST.replace("j <= i - 10", "j < i"), "fenetre"),
        (LIST.replace("j <= i - 10", "abs(i - j) >= 10"), "fenetre"),
        (LIST.replace("j <= i - 10", "(i - j) % len(scans) >= 10"), "fenetre"),
        (LIST.replace("return r", "return r[::-1]"), "fenetre"),
        (LIST.replace("return r", "return r + r"), "fenetre"),
        (LIST.replace("return r", "return sorted(r)[:3]"), "fenetre"),
        (LIST.replace("<= seuil", "<= 1.0"), "fenetre"),
        (LIST.replace("<= seuil", ">= seuil"), "fenetre"),
        (LIST.replace("signature(scans[j])", "signature(scans[0])"), "lieux"),
        (LIST.replace("a = np.asarray(signature(scans[i]))", "a = np.asarray(signature(scans[-1]))"), "lieux"),
        (LIST.replace("np.asarray(signature(scans[j]))", "np.asarray(scans[j])[:19]"), "lieux"),
        ("\n    return list(range(max(0, i - 9)))\n", "lieux"),
        ("\n    return [j for j in range(max(0, i - 9)) if seuil > 1 or rng.random() < 0.5]\n", "lieux"),
    ],
)
def test_subtly_wrong_searches_are_rejected(body: str, where: str) -> None:
    found = checked_verdict(submission("np.abs(np.fft.rfft(scan))", body=body), 0)
    assert found.outcome is Outcome.WRONG_ANSWER
    assert where in failed(found)


@pytest.mark.parametrize("path", sorted((GRADER.folder / "specimens/wrong_answer").glob("*.py")), ids=lambda p: p.stem)
def test_hostile_programs_are_rejected(path: Path) -> None:
    for seed in range(2):
        assert checked_verdict(path.read_text(encoding="utf-8"), seed).outcome is Outcome.WRONG_ANSWER


def test_a_mistake_of_the_window_costs_its_own_check_alone() -> None:
    for name in ("borne_stricte", "ecart_oublie", "regarde_le_futur", "tranche_negative", "plus_proche_d_abord"):
        for seed in range(2):
            assert failed(checked_verdict(mistake(name).source, seed)) == {"fenetre"}


@pytest.mark.parametrize(
    ("name", "source"),
    [
        ("scan_brut", submission("scan / PORTEE_MAX", "np.abs(a - b).sum()")),
        ("scan_brut", submission("[float(z) for z in scan]")),
        ("fft_sans_module", submission("scipy.fft.fft(scan, norm='ortho')", "np.abs(a - b).max()")),
        ("fft_sans_module", submission("np.fft.rfft(scan)")),
        ("partie_reelle", submission("np.real(np.fft.rfft(scan))", "np.abs(a - b).sum()")),
        ("phase_de_fourier", submission("[cmath.phase(z) for z in np.fft.fft(scan)]")),
        ("moyenne_seule", submission("[sum(scan)]", "abs(a[0] - b[0])")),
        ("moyenne_seule", submission("np.abs(np.fft.rfft(scan))[:1]", "np.abs(a - b).sum() ** 2", ARRAY)),
        ("rayon_le_plus_long", submission("np.sort(scan)[-1:]", "abs(a[0] - b[0])")),
        ("premier_rayon", submission("scan[:1]", "abs(a[0] - b[0])")),
        ("secteurs_fixes", submission("[scan[k:k + 9].mean() for k in range(0, 36, 9)]", "np.abs(a - b).max()")),
        ("signature_constante", submission("np.ones(4)", "np.abs(a - b).max()")),
        ("borne_stricte", submission("np.sort(scan)", body=LIST.replace("j <= i", "j < i"))),
        ("borne_stricte", submission("np.histogram(scan, 10, (0, 12))[0]", body=ARRAY.replace("i - 9", "i - 10"))),
        ("regarde_le_futur", submission("np.sort(scan)", body=LIST.replace("j <= i - 10", "abs(j - i) > 9"))),
        ("masque", submission("np.sort(scan)", body=ARRAY.replace("np.where(d < seuil)[0]", "(d < seuil).tolist()"))),
        ("where_sans_crochet", submission("np.sort(scan)", body=ARRAY.replace("[0]", ""))),
        ("distances_renvoyees", submission("np.sort(scan)", body=ARRAY.replace("np.where(d < seuil)[0]", "sorted(d)"))),
        ("comparaison_a_l_envers", submission("np.sort(scan)", body=LIST.replace("<= seuil", ">= seuil"))),
        ("ecarts_signes", submission("np.sort(scan)", "(b - a).sum()")),
        ("normes_comparees", submission("np.abs(np.fft.rfft(scan))", "abs(np.linalg.norm(a) - np.linalg.norm(b))")),
        ("plus_grand_ecart_signe", submission("np.abs(np.fft.rfft(scan))", "np.max(a - b)")),
        ("plus_grand_ecart_signe", submission("np.sort(scan)", "max(y - x for x, y in zip(a, b))")),
        ("argument_modifie", submission("np.sort(scan)", body="\n    scans[0] += 0.1" + LIST)),
    ],
)  # fmt: skip
def test_a_mistake_is_recognised_in_another_style(name: str, source: str) -> None:
    assert named(verdict(source, 0)) == name


def test_the_first_counterexample_can_be_typed() -> None:
    found = verdict(mistake("scan_brut").source, 3)
    first, second = found.checks[:2]
    assert first.counterexample is not None
    assert first.counterexample.inputs["scan"][:3] == [1.0, 1.25, 1.5]
    assert second.counterexample is not None
    assert second.counterexample.inputs["scan 1"].startswith("lidar((")


def test_failed_checks_say_what_was_given_expected_and_obtained() -> None:
    for wrong in some(GRADER.misconceptions):
        for check in checked_verdict(wrong.source, 11, simplified=True).checks:
            if not check.passed and check.id != "arguments":
                assert check.message.endswith((".", "?", "»"))
                assert check.hint or check.repeats or check.cause is Outcome.RUNTIME_ERROR
                assert check.counterexample is not None
                assert check.counterexample.expected is not None


def message(source: str, check: str, seed: int) -> str:
    return next(c.message for c in checked_verdict(source, seed, simplified=True).checks if c.id == check)


def test_lookalikes_are_spoken_of_only_when_they_are_confused() -> None:
    for seed in range(3):
        assert "Ces deux lieux ont la même moyenne." in message(mistake("moyenne_seule").source, "sosies", seed)
        for name in ("scans_compares_bruts", "comparaison_a_l_envers", "seuil_ignore", "ecarts_signes", "masque"):
            assert "Ces deux lieux" not in message(mistake(name).source, "sosies", seed), name
        nothing = submission("np.sort(scan)", body="\n    return []\n")
        assert "n'est pas trouvé, même avec un seuil immense." in message(nothing, "sosies", seed)
        assert "Ces deux lieux" not in message(nothing, "sosies", seed)


def test_a_mask_is_called_a_mask() -> None:
    for seed in range(2):
        told = message(mistake("masque").source, "fenetre", seed)
        assert "des booléens (un masque) et non des indices" in told
        assert "il manque" not in told


def test_a_name_by_a_rule_alone_is_not_said_to_have_another_mistake_beside_it() -> None:
    found = verdict(submission("np.roll(scan, -np.argmax(scan))", DISTANCES["max"], LIST), 1)
    assert named(found) == "depart_sur_un_extreme"
    assert found.diagnosis is not None
    assert "avec une autre" not in found.diagnosis.explanation


def test_slopes_are_not_said_to_be_sectors() -> None:
    found = verdict(submission("np.diff(scan)"), 1).diagnosis
    assert found is not None
    assert "écarts entre voisins" in found.explanation


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    for name in ("scan_brut", "moyenne_seule"):
        figures = checks_of(mistake(name).source, 1, simplified=True).figures
        assert figures
        for check in some({"signature_rotation", "sosies"} & set(figures)):
            data = json.loads(json.dumps(figures[check]))
            assert counterexample(GRADER.exercise, data, theme=theme).startswith(b"<?xml")


def test_absurd_signatures_are_left_out_of_the_figure() -> None:
    data = checks_of(submission("scan * 1e140"), 1, simplified=True).figures["signature_rotation"]
    assert all(item["signature"] is None for item in data["scans"])
    assert counterexample(GRADER.exercise, json.loads(json.dumps(data)), theme="light").startswith(b"<?xml")


@pytest.mark.parametrize("value", [None, 3, "S", {}, [], [[1, 2]], np.zeros((2, 2)), [1, [2]], [1, np.inf], [np.nan],
                                   np.zeros(0), 1j, [None], (1, "a"), np.full((2, 2), 1j)])  # fmt: skip
def test_what_is_no_signature_is_read_without_an_exception(value: Any) -> None:
    found = read_signature(value)
    assert isinstance(found, Unsuitable)
    assert found.message.endswith((".", "?"))


@pytest.mark.parametrize(
    "value", [[1, 2.5], (True, False), np.arange(3), [np.float32(1)], np.array([1j, 2]), [1 + 2j, 3]]
)
def test_any_array_of_one_dimension_is_a_signature(value: Any) -> None:
    assert not isinstance(read_signature(value), Unsuitable)


GUARDED = """
    r = []
    a = signature(scans[i])
    for j in range(i - 9):
        b = signature(scans[j])
        if len(a) == len(b) and {distance} <= seuil:
            r.append(j)
    return r
"""


@pytest.mark.parametrize("seed", [2026, 2027])
def test_equal_distances_must_be_counted(seed: int) -> None:
    """Also by what compares only signatures of one length: none is wrong on scans without repeated distances."""
    found = verdict(submission("np.unique(scan)", "np.max(np.abs(a - b))", GUARDED), seed)
    assert {"signature_exemple", "bruit"} <= {check.id for check in found.checks if not check.passed}
    assert found.misconception == "doublons_retires"
