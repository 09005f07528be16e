"""Each « À vous » of the lessons has its folded answer, whose numbers are those that the changed cell prints."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache

import pytest

from curriculum.l20.figures import reponses
from server.cells.process import POLICY
from server.cells.run import run_cell
from server.course.models import Lesson
from server.sandbox import Sandbox
from tests.support.quick import the_course

ASKED = re.compile(r"^(?!\s*#).*À vous : .*$", re.MULTILINE)
ANSWER = re.compile(r"^:::+ repli Réponse\n(.*?)^:::+$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"(?<![\w.`])\d[\d\u00a0 ]*(?:,\d+)|(?<![\w.`,])\d{1,3}(?: \d{3})+")
CODE = re.compile(r"`[^`]*`")


@cache
def lessons() -> dict[str, Lesson]:
    """Of two lessons of one name, that of the last module: no name is asked for of which there are two."""
    return {lesson.slug: lesson for module in the_course().modules.values() for lesson in module.lessons}


FIRST, SECOND = 'publier("/scan", lidar((4.5', 'publier("/scan", lidar((1.4, 1.5, 0.0), 36))'
COUNTING = 'compte = []\ns_abonner("/scan", lambda scan: compte.append(1))\n'
TOLD = '\nprint("scans reçus :", len(compte))'
COMB = "np.searchsorted(np.cumsum(poids)[:-1], (rng.random() + np.arange(N)) / N)"
#: What readers try: lesson, cell, and what they replace in it.
TRIALS: list[tuple[str, str, dict[str, str]]] = [
    ("slam", "carre-qui-derive", {}),
    ("localiser", "scan-polaire", {"0.35)": "1.92)"}),
    ("localiser", "scan-polaire", {}),
    ("localiser", "scan-polaire", {"8.6, 7.4": "9.6, 7.4"}),
    (
        "localiser",
        "derive",
        {"cap = np.cumsum(erreurs, axis=1) - erreurs / 2 ": "cap = np.sqrt(n) * erreurs[:, :1] * np.ones(n)"},
    ),
    ("localiser", "derive", {"1000, 0.115": "2000, 0.115"}),
    ("localiser", "derive", {}),
    ("localiser", "couloir", {}),
    ("localiser", "couloir", {"False, False]": "False, True]"}),
    ("localiser", "couloir", {"0, 0, 1, 1, 0": "0, 0, 0, 1, 0"}),
    ("localiser", "couloir", {"0.8, 0.2)": "0.5, 0.5)"}),
    ("localiser", "mcl", {"N, R = 2000": "rng = np.random.default_rng(1)\nN, R = 200"}),
    ("localiser", "mcl", {"N, R = 2000": "rng = np.random.default_rng(2)\nN, R = 200"}),
    ("localiser", "mcl", {"N, R = 2000": "rng = np.random.default_rng(3)\nN, R = 200"}),
    ("localiser", "mcl", {"N, R = 2000": "rng = np.random.default_rng(4)\nN, R = 200"}),
    ("localiser", "mcl", {"N, R = 2000": "rng = np.random.default_rng(5)\nN, R = 200"}),
    ("localiser", "mcl", {"N, R = 2000": "rng = np.random.default_rng(6)\nN, R = 200"}),
    ("localiser", "mcl", {"virage, 0.1, 0.08": "virage, 0.0, 0.0"}),
    ("localiser", "mcl", {}),
    ("localiser", "peigne", {"** 3": "** 0"}),
    ("localiser", "neff", {}),
    (
        "slam",
        "carre-qui-derive",
        {
            "def matrice": "rng = np.random.default_rng(1)\ndef matrice",
            "matrice(1, 0, biais)": "matrice(1, 0, rng.normal(0, np.radians(0.5)))",
        },
    ),
    (
        "slam",
        "carre-qui-derive",
        {
            "def matrice": "rng = np.random.default_rng(2)\ndef matrice",
            "matrice(1, 0, biais)": "matrice(1, 0, rng.normal(0, np.radians(0.5)))",
        },
    ),
    (
        "slam",
        "carre-qui-derive",
        {
            "def matrice": "rng = np.random.default_rng(3)\ndef matrice",
            "matrice(1, 0, biais)": "matrice(1, 0, rng.normal(0, np.radians(0.5)))",
        },
    ),
    ("slam", "trois-points", {"[0, 1]], dtype=float)\n\np, q": "[0, 2]], dtype=float)\n\np, q"}),
    ("slam", "icp-en-petit", {"angle, t = 0.0": "angle, t = 1.5"}),
    ("slam", "icp-en-petit", {"angle, t = 0.0": "angle, t = -1.0"}),
    ("slam", "icp-en-petit", {}),
    ("slam", "anneau-1d", {}),
    ("slam", "anneau-1d", {"(0, 3, 0, 4)": "(0, 3, 0, 100)"}),
    ("slam", "anneau-1d", {"(0, 3, 0, 4)": "(0, 3, 0, 0.01)"}),
    ("slam", "anneau-1d", {"(0, 3, 0, 4)]": "(0, 3, 0, 4), (1, 2, 0, 4)]"}),
    ("slam", "signature-de-fourier", {"n = 36": "n = 360"}),
    ("slam", "signature-de-fourier", {}),
    ("cartographier", "histoire-d-une-case", {}),
    ("cartographier", "histoire-d-une-case", {"TTvTTTvT": "vvTTTTTT"}),
    ("cartographier", "histoire-d-une-case", {"TTvTTTvT": "TTT", "0.7 / 0.3": "0.9 / 0.1", "0.3 / 0.7": "0.1 / 0.9"}),
    ("cartographier", "petite-carte", {}),
    ("cartographier", "petite-carte", {"(4.5, 8.0, 0.0)]": "(4.5, 8.0, 0.0), (17.5, 12.5, 0.0)]"}),
    ("cartographier", "petite-carte", {"(4.5, 8.0, 0.0)]": "(4.5, 8.0, 0.0), (4.5, 12.5, 0.0)]"}),
    ("cartographier", "petite-carte", {"lidar(pose, 72)": "lidar(pose, 72, 0.2)"}),
    ("cartographier", "saturation", {}),
    ("cartographier", "saturation", {"passe=100": "passe=3"}),
    ("cartographier", "poses-fausses", {"derive = 0.02": "derive = 0.05"}),
    ("cartographier", "poses-fausses", {"derive = 0.02": "derive = -0.05"}),
    ("ros2", "bus", {FIRST: COUNTING + FIRST, SECOND: SECOND + TOLD}),
    ("ros2", "reperes", {}),
    ("ros2", "reperes", {"k % 20 == 19": "k % 10 == 9"}),
    ("ros2", "reperes", {"k % 20 == 19": "k % 5 == 4"}),
    ("ros2", "fenetre", {}),
    ("ros2", "fenetre", {"(1.5, 2.0, 0.0)": "(1.5, 4.3, np.pi / 2)"}),
    ("ros2", "fenetre", {"(1.5, 2.0, 0.0)": "(1.5, 5.3, np.pi / 2)"}),
    ("methodes", "angles", {"np.pi - (np.pi - a) % (2 * np.pi)": "(a + np.pi) % (2 * np.pi) - np.pi"}),
    ("methodes", "angles", {}),
    ("methodes", "produit", {"    poids = np.exp": "    log_poids = 0.1 * log_poids\n    poids = np.exp"}),
    ("methodes", "produit", {}),
    ("methodes", "cloture", {}),
    (
        "methodes",
        "cloture",
        {"poteaux = np.arange(10.0)": "poteaux = np.arange(10.0)\npoteaux = np.delete(poteaux, 4)"},
    ),
    ("filtre-bayesien", "trois-filtres", {}),
    ("filtre-bayesien", "trois-filtres", {"pas = 0.5": "pas = 1"}),
    ("filtre-bayesien", "trois-filtres", {"pas = 0.5": "pas = 2"}),
    ("filtre-bayesien", "trois-filtres", {"N = 1000": "N = 10"}),
    ("filtre-bayesien", "trois-filtres", {"4.4": "0.5"}),
    ("filtre-bayesien", "croissant", {"deg2rad(25)": "deg2rad(5)"}),
    ("filtre-bayesien", "croissant", {"np.pi / 2, ": "np.pi / 4, "}),
    ("filtre-bayesien", "croissant", {}),
    ("filtre-bayesien", "dimension", {"10_000": "100_000"}),
    ("filtre-bayesien", "dimension", {}),
    ("telemetre", "passant", {}),
    ("telemetre", "passant", {"scan[[34": "# scan[[34"}),
    ("telemetre", "passant", {"0.7, 0.1, 0.1, 0.1": "0.97, 0.01, 0.01, 0.01"}),
    ("rayons", "correlation", {"tau, essais = 10.0, 5.0": "tau, essais = 10.0, 0.0"}),
    ("rayons", "correlation", {"tau, essais = 10.0, 5.0": "tau, essais = 10.0, 20.0"}),
    ("rayons", "champ", {"fin = 8": "fin = 1"}),
    ("rayons", "champ", {}),
    ("kidnappe", "genealogie", {"N = 200": "rng = np.random.default_rng(1)\nN = 200"}),
    ("kidnappe", "genealogie", {"N = 200": "rng = np.random.default_rng(2)\nN = 200"}),
    ("kidnappe", "genealogie", {"N = 200": "rng = np.random.default_rng(3)\nN = 200"}),
    ("kidnappe", "genealogie", {"rng.choice(N, size=N, p=poids) ": COMB}),
    ("amers", "jacobienne-verifiee", {}),
    ("amers", "jacobienne-verifiee", {"[[-s, c]": "[[s, c]"}),
    ("amers", "jacobienne-verifiee", {"h=1e-6": "h=1e-2"}),
    ("amers", "jacobienne-verifiee", {"h=1e-6": "h=1e-12"}),
    ("robuste", "noyau-de-h", {}),
    ("robuste", "noyau-de-h", {"        H += J.T": "        J[0] = 0\n        H += J.T"}),
    ("robuste", "fausse-mesure", {}),
    ("robuste", "fausse-mesure", {"9.0]": "9.0, 9.0, 9.0]"}),
    ("robuste", "fausse-mesure", {"9.0]": "9.0, 9.0, 9.0, 9.0, 9.0, 9.0]"}),
    ("robuste", "fausse-mesure", {"9.0]": "9.0, 9.0, 9.0, 9.0]"}),
    ("robuste", "fausse-mesure", {"9.0]": "9.0, 9.0, 9.0, 9.0, 9.0]"}),
    ("kalman", "thermometres", {}),
    ("kalman", "thermometres", {"2.0, 1.0, 0.0": "2.0, 2.0, 0.0"}),
    ("kalman", "thermometres", {"2.0, 1.0, 0.0": "2.0, 6.0, 0.0"}),
    ("kalman", "thermometres", {"2.0, 1.0, 0.0": "2.0, 1.0, 1.0"}),
    ("kalman", "rail", {}),
    ("kalman", "rail", {"    m, v = m + K": "    K = 0.05\n    m, v = m + K"}),
    ("kalman", "rail", {"    m, v = m + K": "    K = 1.0\n    m, v = m + K"}),
    ("kalman", "rail", {"1.0**2": "100.0**2"}),
    ("kalman", "vitesse", {}),
    ("kalman", "vitesse", {"[[1.0, 0.0]]": "[[0.0, 1.0]]"}),
    ("kalman", "vitesse", {"secousse**2 * np": "0 * np"}),
    ("kalman", "tangente", {}),
    ("kalman", "tangente", {"0.1**2": "0.5**2"}),
    ("kalman", "coherence", {}),
    ("kalman", "coherence", {"r_cru = q, r": "r_cru = q / 9, r"}),
    ("kalman", "coherence", {"r_cru = q, r": "r_cru = q * 9, r"}),
    ("kalman", "portillon", {}),
    ("kalman", "portillon", {"9.0": "1e9"}),
    ("kalman", "portillon", {"9.0": "1.0"}),
    ("kalman", "portillon", {"q_cru, seuil = q": "q_cru, seuil = 1e-6", "x += u": "x += 1.5 * u"}),
]
#: Numbers of the answers that no cell prints: how they are found.
WORKED_OUT = {
    "localiser": [2 * 2**0.5, 0.99**100, 27.07 / 9.77],
    "slam": [40**0.5, 1.5, 1.0, 0.01],
    "cartographier": [81 / 82, 729 / 730, 2.197, 0.847, 3 * 0.847, 0.9, 0.7, 0.05, 0.2],
    "ros2": [0.6, 5.3],
    "methodes": [0.1, 0.6, 1.4],
    "filtre-bayesien": [],
    "telemetre": [0.01, 0.2],
    "amers": [3.8, 4.2, 2.5],
    "robuste": [],
    "kidnappe": [],
    "kalman": [0.8**0.5, 0.8, 1.0],
}


def source(lesson: Lesson) -> str:
    return lesson.text.source.text


def test_every_invitation_to_try_has_its_folded_answer() -> None:
    asked = 0
    for lesson in (lesson for module in the_course().modules.values() for lesson in module.lessons):
        text = source(lesson)
        for found in ASKED.finditer(text):
            asked += 1
            assert re.match(r"\n\n:::+ repli Réponse\n", text[found.end() :]), found[0][:60]
        assert len(ANSWER.findall(text)) == len(ASKED.findall(text))
    assert asked >= 39


def test_every_trial_changes_what_its_cell_holds() -> None:
    for slug, name, edits in TRIALS:
        code = next(cell.code for cell in lessons()[slug].cells if cell.name == name)
        assert all(old in code for old in edits), (slug, name)


def numbers(text: str) -> Iterator[str]:
    """The numbers of an answer that have decimals or thousands, as a program prints them."""
    plain = CODE.sub("", text).replace("{,}", ",").replace("−", "-")
    for found in NUMBER.finditer(plain):
        yield re.sub(r"[\s\u00a0]", "", found[0]).replace(",", ".")


@pytest.mark.slow
@pytest.mark.parametrize("slug", sorted({slug for slug, *_ in TRIALS}))
def test_each_number_of_an_answer_is_what_the_changed_cell_prints(slug: str) -> None:
    printed: list[float] = list(WORKED_OUT[slug])
    with Sandbox(the_course().kits, POLICY) as sandbox:
        for _, name, edits in (trial for trial in TRIALS if trial[0] == slug):
            code = next(cell.code for cell in lessons()[slug].cells if cell.name == name)
            for old, new in edits.items():
                code = code.replace(old, new)
            shown = run_cell(sandbox, lessons()[slug].module, code.encode())
            assert shown.fault is None
            printed += [float(one) for one in re.findall(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?", shown.stdout)]
    text = "".join(ANSWER.findall(source(lessons()[slug])))
    told = list(numbers(text))
    assert told or slug == "kidnappe"
    for number in told:
        decimals = len(number.partition(".")[2])
        assert any(f"{abs(one):.{decimals}f}" == number for one in printed), f"{slug}: {number}"


def test_the_drawings_of_the_answers_show_the_numbers_of_the_answers() -> None:
    ends = [reponses.settled(start)[2] for start in reponses.STARTS]
    assert [f"{end:.2f}" for end in ends] == ["0.28", "2.00", "-1.21"]
    beliefs = [reponses.corridor(*case) for _, *case in reponses.CORRIDORS]  # type: ignore[arg-type]
    assert [(int(one.argmax()), f"{one.max():.3f}") for one in beliefs] == [
        (7, "0.417"), (9, "0.376"), (3, "0.258"), (9, "0.340"),
    ]  # fmt: skip
    assert beliefs[2][7] == pytest.approx(beliefs[2][3])
    for every, before in ((20, 19), (10, 9), (5, 4)):
        assert abs(reponses.corrected(every)[:, 1]).max() == pytest.approx(6e-4 * before * (before - 1) / 2, rel=2e-3)
