"""l20/reechantillonnage: honest combs pass, every catalogued mistake is named whatever is drawn, figures draw."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np
import pytest
from scipy import stats

from graders.core.code.bench import Bench
from graders.core.code.grading import FRESH_REENACTOR
from graders.core.code.runner import Runner
from graders.core.contract.local import LOCAL
from graders.core.contract.outcomes import Outcome
from graders.core.contract.streams import stream
from graders.l20.reechantillonnage import trials
from graders.l20.reechantillonnage.harvest import harvest
from graders.l20.reechantillonnage.judge import TAIL, is_comb, plausible
from graders.plotting import counterexample
from reference.filters.resampling import comb_resampling, systematic_resampling
from tests.support.quick import THEMES, some
from tests.support.shipped import CODE
from tests.support.verdicts import named, verdict_of

GRADER = CODE["l20/reechantillonnage"]
verdict = partial(verdict_of, GRADER.exercise)

# Whether a file loads at all is the sandbox's business.
SPECIMENS = sorted(
    specimen.path
    for specimen in GRADER.specimens()
    if specimen.outcome not in (Outcome.SYNTAX_ERROR, Outcome.IMPORT_ERROR)
)
N_EFF = "def n_eff(poids):\n    return 1.0 / np.sum(poids ** 2)\n\n\n"

HONEST = {
    "fleche": """
d = (np.arange(N) + 1.0 - rng.random()) / N
return particules[np.searchsorted(np.cumsum(poids), d, side='left').clip(max=N - 1)]
""",
    "liste": """
r = rng.random(1)
return [particules[k].tolist() for k in np.searchsorted(np.cumsum(poids), (np.arange(N) + r) / N).clip(max=N - 1)]
""",
    "simple_precision": """
i = np.searchsorted(np.cumsum(poids), (np.arange(N) + rng.random()) / N)
return particules[i.clip(max=N - 1)].astype(np.float32)
""",
    "integers": """
u = rng.integers(1, 2**53) / 2**53
return particules[np.searchsorted(np.cumsum(poids), (np.arange(N) + u) / N).clip(max=N - 1)]
""",
    "entropie_neuve": """
u = np.random.default_rng().random()
return particules[np.searchsorted(np.cumsum(poids), (np.arange(N) + u) / N).clip(max=N - 1)]
""",
    "permutation_d_abord": """
o = rng.permutation(N)
u = rng.random()
return particules[o][np.searchsorted(np.cumsum(poids[o]), (np.arange(N) + u) / N).clip(max=N - 1)]
""",
    "comparaison_complete": """
d = (np.arange(N) + rng.random()) / N
return particules[np.minimum((d[:, None] > np.cumsum(poids)[None, :]).sum(axis=1), N - 1)]
""",
    "depuis_la_fin": """
d = (np.arange(N) + rng.random()) / N
return particules[N - 1 - np.searchsorted(np.cumsum(poids[::-1]), d).clip(max=N - 1)]
""",
    "dents_par_addition": """
d, c, i, sortie = rng.uniform(0, 1 / N), 0.0, -1, []
while len(sortie) < N:
    while c < d and i < N - 1:
        i += 1
        c += poids[i]
    sortie.append(particules[i])
    d += 1 / N
return np.array(sortie)
""",
    "par_particule": """
u, cumul, deja, sortie = rng.random(), 0.0, 0, []
for p, w in zip(particules, poids):
    cumul += N * w
    while deja + u < cumul and deja < N:
        sortie.append(p)
        deja += 1
while len(sortie) < N:
    sortie.append(particules[np.flatnonzero(poids)[-1]])
return np.stack(sortie)
""",
}

WRONG = {
    "demi_plage": """
u = rng.random() / 2
return particules[np.searchsorted(np.cumsum(poids), (np.arange(N) + u) / N)]
""",
    "un_sur_n_plus_un": """
u = rng.random() * N / (N + 1)
return particules[np.searchsorted(np.cumsum(poids), (np.arange(N) + u) / N)]
""",
    "jamais_aux_bords": """
u = 0.2 + 0.6 * rng.random()
return particules[np.searchsorted(np.cumsum(poids), (np.arange(N) + u) / N)]
""",
    "deux_positions": """
u = rng.choice([0.25, 0.75])
return particules[np.searchsorted(np.cumsum(poids), (np.arange(N) + u) / N)]
""",
    "carre_des_poids": """
c = np.cumsum(poids ** 2) / np.sum(poids ** 2)
return particules[np.searchsorted(c, (np.arange(N) + rng.random()) / N).clip(max=N - 1)]
""",
    "n_moins_un_dents": """
d = (np.arange(N) + rng.random()) / (N + 1)
return particules[np.searchsorted(np.cumsum(poids), d)]
""",
    "une_dent_de_trop": """
d = (np.arange(N + 1) + rng.random()) / (N + 1)
return particules[np.searchsorted(np.cumsum(poids), d).clip(max=N - 1)]
""",
    "bruit": """
i = np.searchsorted(np.cumsum(poids), (np.arange(N) + rng.random()) / N)
return particules[i] + rng.normal(0, 1e-6, particules.shape)
""",
    "colonnes_melangees": """
c = np.cumsum(poids)
choix = np.searchsorted(c, (np.arange(N) + rng.random()) / N).clip(max=N - 1)
return np.stack([rng.permutation(colonne[choix]) for colonne in particules.T], axis=1)
""",
    "plate": """
return particules[np.searchsorted(np.cumsum(poids), (np.arange(N) + rng.random()) / N)].ravel()
""",
    "transposee": """
return particules[np.searchsorted(np.cumsum(poids), (np.arange(N) + rng.random()) / N)].T
""",
    "moyenne_repetee": """
return np.tile(poids @ particules, (N, 1))
""",
    "survie": """
return particules[rng.random(N) < N * poids]
""",
    "lignes_inegales": """
return particules, [[1.0], [1.0, 2.0]]
""",
    "texte": """
return str(particules)
""",
    "zeros": """
return np.zeros_like(particules)
""",
    "nan": """
return np.full_like(particules, np.nan)
""",
    "infini": """
return np.full_like(particules, np.inf)
""",
    "immense": """
return np.full_like(particules, 1e308)
""",
    "petits_nuages_seulement": """
c = np.cumsum(poids)
u = rng.random() if N < 20 else rng.random(N)
return particules[np.searchsorted(c, (np.arange(N) + u) / N).clip(max=N - 1)]
""",
}

STYLES = {
    "tirages_independants": [
        """
return particules[rng.choice(N, N, p=poids)]
""",
        """
import random
return np.array(random.choices(particules.tolist(), poids, k=N))
""",
    ],
    "un_tirage_par_dent": [
        """
c = np.cumsum(poids)
return [particules[min(int(np.sum(c < (m + rng.random()) / N)), N - 1)] for m in range(N)]
""",
    ],
    "reste_tire_au_sort": [
        """
k = (N * poids + 1e-9).astype(int)
r = np.maximum(N * poids - k, 0)
m = N - k.sum()
plus = rng.choice(N, m, p=r / r.sum()) if m else np.zeros(0, int)
return np.concatenate([np.repeat(particules, k, axis=0), particules[plus]])
""",
    ],
    "peigne_fige": [
        """
np.random.seed(42)
return particules[np.searchsorted(np.cumsum(poids), (np.arange(N) + np.random.rand()) / N)]
""",
        """
return particules[np.searchsorted(np.cumsum(poids), (np.arange(N) + 0.9) / N)]
""",
        """
f = reechantillonner_systematique
f.u = getattr(f, 'u', 0) or rng.uniform(0.6, 1)
return particules[np.searchsorted(np.cumsum(poids), (np.arange(N) + f.u) / N)]
""",
    ],
    "peigne_centre": [
        """
return [particules[int(np.sum(np.cumsum(poids) < (m + 0.5) / N))] for m in range(N)]
""",
    ],
    "decalage_trop_petit": [
        """
r = rng.uniform(0, 1 / N)
return particules[np.searchsorted(np.cumsum(poids), [(m + r) / N for m in range(N)])]
""",
    ],
    "decalage_trop_grand": [
        """
u = rng.random()
c = np.cumsum(poids).tolist()
return [particules[[k for k in range(N) if c[k] > u + m / N][0]] for m in range(N)]
""",
    ],
    "poids_ignores": [
        """
return rng.choice(particules, N)
""",
    ],
    "meilleure_seule": [
        """
return [max(zip(poids, particules.tolist()))[1]] * N
""",
    ],
    "copies_tronquees": [
        """
return [p for p, w in zip(particules, poids) for _ in range(int(N * w + 1e-9))]
""",
    ],
    "particules_ponderees": [
        """
return [[w * x for x in p] for p, w in zip(particules, poids)]
""",
    ],
    "indices_au_lieu_de_copies": [
        """
return list(np.searchsorted(np.cumsum(poids), (np.arange(N) + rng.random()) / N))
""",
    ],
}


def submission(body: str) -> str:
    return N_EFF + "def reechantillonner_systematique(particules, poids):\n" + indent(f"N = len(poids)\n{body}", "    ")


def specimen(path: Path) -> str:
    return path.read_text(encoding="utf-8").replace("from l20 import np, rng\n", "")


def mistake(name: str) -> Any:
    return next(m for m in GRADER.misconceptions if m.id == name)


def test_the_solution_gets_full_marks_on_many_seeds() -> None:
    assert all(verdict(GRADER.solution, seed).score == 1.0 for seed in range(30))


@pytest.mark.parametrize("name", STYLES)
def test_mistakes_are_named_in_any_style_and_with_any_generator(name: str) -> None:
    for body in some(STYLES[name]):
        found = verdict(submission(body), 7)
        assert found.diagnosis is not None, body
        assert found.diagnosis.id == name


@pytest.mark.parametrize("body", HONEST.values(), ids=HONEST)
def test_honest_combs_pass(body: str) -> None:
    for seed in range(2):
        assert verdict(submission(body), seed).outcome is Outcome.OK


@pytest.mark.parametrize("body", WRONG.values(), ids=WRONG)
def test_subtle_mistakes_are_rejected_with_what_was_given_expected_and_obtained(body: str) -> None:
    found = verdict(submission(body), 3)
    assert found.outcome is not Outcome.OK
    for check in (c for c in found.checks if not c.passed):
        assert check.counterexample is not None
        assert {"particules", "poids"} <= set(check.counterexample.inputs)
        assert check.message
        assert check.hint or check.repeats or check.cause is Outcome.RUNTIME_ERROR
    json.dumps(found.to_json(), allow_nan=False)


def test_doing_nothing_earns_nothing_for_the_comb() -> None:
    found = verdict(N_EFF + "def reechantillonner_systematique(particules, poids):\n    return particules\n", 2)
    assert {c.id for c in found.checks if c.passed} == {"neff_extremes", "neff_hasard", "arguments"}


@pytest.mark.parametrize("line", ["poids /= poids.sum()", "poids.sort()", "particules[0] += 0.125"])
def test_arguments_modified_in_place_are_seen(line: str) -> None:
    body = f"garde, p = particules.copy(), poids.copy()\n{line}\nparticules, poids = garde, p\n{HONEST['fleche']}"
    found = verdict(submission(body), 5)
    assert [c.id for c in found.checks if not c.passed] == ["arguments"]
    assert found.diagnosis is not None
    assert found.diagnosis.id == "argument_modifie"


def test_counterexamples_are_small() -> None:
    separate = verdict(mistake("tirages_independants").source, 1).checks[3].counterexample
    assert separate is not None
    assert separate.inputs["poids"] == [0.5, 0.5]
    frozen = verdict(mistake("peigne_centre").source, 1).checks[5].counterexample
    assert frozen is not None
    assert len(frozen.inputs["poids"]) == 4
    largest = verdict(mistake("inverse_du_plus_grand").source, 1).checks[1].counterexample
    assert largest is not None
    assert largest.inputs["poids"] == [0.75, 0.25]


def test_a_reenactment_cut_short_sees_what_the_whole_one_sees() -> None:
    kit = GRADER.kit(stream(9, "kit"))
    whole, short = (
        FRESH_REENACTOR.reenact(mistake("poids_ignores"), checks=GRADER.checks, kit=kit, seed=9).observe(enough)
        for enough in (lambda seen: False, lambda seen: len(seen) >= 3)
    )
    assert len(short) < len(whole)
    assert short == whole[: len(short)]


@pytest.mark.parametrize(("n", "p"), [(250, 0.12), (250, 0.8), (150, 0.99), (150, 0.05), (1000, 0.03), (40, 0.5)])
def test_plausible_ranges_have_the_tails_that_are_claimed(n: int, p: float) -> None:
    few, many = plausible(n, p)
    binomial = stats.binom(n, p)
    assert binomial.cdf(few - 1) <= TAIL * (1 + 1e-6)
    assert binomial.sf(many) <= TAIL * (1 + 1e-6)
    assert binomial.cdf(few) > TAIL
    assert binomial.sf(many - 1) > TAIL


def test_copies_of_a_comb_are_recognised() -> None:
    rng = np.random.default_rng(3)
    for n in (2, 5, 9):
        weights = trials.uneven_weights(rng, n)
        assert is_comb(weights, systematic_resampling(weights, rng).copies)
    assert not is_comb(np.array([0.3, 0.3, 0.4]), np.array([3, 0, 0]))
    assert is_comb(np.array([0.5, 0.25, 0.25, 0.0]), comb_resampling([2, 1, 1, 0], 0.3).copies)


@pytest.mark.parametrize(("n", "d"), [(2, 1), (5, 4), (60, 3), (500, 1), (500, 4)])
def test_rows_are_recognised_up_to_the_tolerance(n: int, d: int) -> None:
    rng = np.random.default_rng(n + d)
    case = trials.scenario(rng, trials.uneven_weights(rng, n), d=d, calls=2)
    almost = submission(HONEST["fleche"]).replace("clip(max=N - 1)]", "clip(max=N - 1)] + 5e-10")
    kit = GRADER.kit(stream(1, "kit"))
    found = harvest(Bench("c", Runner(LOCAL, almost.encode(), kit), rng, kit), case)
    assert found.objection is None
    assert np.all((found.copies >= case.low) & (found.copies <= case.high))


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("name", ["poids_ignores", "un_tirage_par_dent"])
def test_figures_draw(theme: str, name: str) -> None:
    figures = GRADER.grade(mistake(name).source.encode(), LOCAL, seed=1, version="v").figures
    assert figures
    drawn = [*json.loads(json.dumps(figures, allow_nan=False)).values()]
    for data in drawn[: 1 if theme == "light" else None]:  # all have one kind
        assert counterexample(GRADER.exercise, data, theme=theme).startswith(b"<?xml")


def test_a_large_cloud_is_drawn_around_its_wrong_particle() -> None:
    figures = GRADER.grade(submission(WRONG["petits_nuages_seulement"]).encode(), LOCAL, seed=2, version="v").figures
    (data,) = json.loads(json.dumps(figures)).values()
    assert data["total"] >= 60
    assert len(data["shares"]) == 24
    assert counterexample(GRADER.exercise, data).startswith(b"<?xml")


@pytest.mark.parametrize(
    ("chosen", "name"),
    [
        ("rng.choice(len(poids), len(poids), replace=False, p=poids)", "sans_remise"),
        ("np.argsort(-poids)", "nuage_inchange"),
        ("rng.permutation(len(poids))", "nuage_inchange"),
    ],
)
def test_a_cloud_without_copies_is_named_by_its_draw(chosen: str, name: str) -> None:
    source = (
        f"{GRADER.solution}\n\ndef reechantillonner_systematique(particules, poids):\n    return particules[{chosen}]\n"
    )
    assert named(verdict(source, 3)) == name
