"""Names that a rule gives: to the mistake that it speaks of, and to none that merely resembles it."""

from __future__ import annotations

import pytest

from graders.core.compare.slips import SLIPS
from tests.content.graders.l20.boucles_styles import LIST, submission
from tests.support.quick import one_in
from tests.support.verdicts import model_with, named, plain_verdict_of

BOUCLES, KABSCH, PREDIRE, COMB, SLAM = (
    f"l20/{slug}" for slug in ("boucles", "kabsch", "predire2d", "reechantillonnage", "slam_graphe")
)
BOXES = "np.histogram(scan, 10, (0.0, 12.0))[0]"
KEEPING = """
def signature(scan):
    return np.sort(scan)

def candidats_boucle(scans, i, seuil, candidats=[]):
    for j in range(i - 9):
        if np.linalg.norm(signature(scans[j]) - signature(scans[i])) <= seuil:
            candidats.append(j)
    return candidats
"""
STRAIGHT_FIRST = "0.8, du, dv), (0.1, du + dv, dv + du), (0.1, du - dv, dv - du)"
STRAIGHT_LAST = "0.1, du + dv, dv + du), (0.1, du - dv, dv - du), (0.8, du, dv)"
OVERWRITTEN = STRAIGHT_FIRST, STRAIGHT_LAST, "nouvelle[y2, x2] += p", "nouvelle[y2, x2] = p"
DIVIDED = "p * bel[y, x]\n    return nouvelle", "p * bel[y, x]\n    return nouvelle / nouvelle.sum()"
SVD = "U, S, Vt = np.linalg.svd(H)"
IDENTITY_FOR_A_MIRROR = "    t = q - R @ p", "    R = np.eye(d) if sens < 0 else R\n    t = q - R @ p"
ARCTAN = f"""def kabsch(P, Q):
    n, d = P.shape
    p, q = P.mean(axis=0), Q.mean(axis=0)
    H = (P - p).T @ (Q - q)
    if d == 2:
        a = np.arctan((H[0, 1] - H[1, 0]) / (H[0, 0] + H[1, 1]))
        R = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    else:
        {SVD}
        sens = np.sign(np.linalg.det(Vt.T @ U.T))
        R = Vt.T @ np.diag([1.0, 1.0, sens]) @ U.T
    return R, q - R @ p
"""
ROUNDED = """
def n_eff(poids):
    return 1 / np.sum(poids ** 2)

def reechantillonner_systematique(particules, poids):
    N = len(particules)
    lignes = [particules[i] for i in range(N) for _ in range(int(round(N * poids[i])))]
    lignes += [particules[np.argmax(poids)]] * N
    return np.array(lignes[:N])
"""
NEAREST = """
    r = [j for j in range(i - 9) if {distance_} <= seuil]
    return sorted(r, key=lambda j: {distance_})[:1]
""".replace("{distance_}", "np.linalg.norm(signature(scans[j]) - signature(scans[i]))")
FREE = "pas[3:] = np.linalg.solve(H[3:, 3:], -b[3:])", "pas[:] = np.linalg.solve(H, -b)"
#: Poses that run away, and systems without a solution, whatever is held; then the first pose that is not.
AWAY = (
    (SLAM, model_with(SLAM, "A, B = jacobiennes(x[i], x[j], z)", "A, B = np.zeros((2, 3, 3))"), None),
    (SLAM, model_with(SLAM, *FREE), "jauge_libre"),
    (SLAM, model_with(SLAM, "xj[2] - xi[2] - z[2])])", "xj[2] - xi[2] - z[2])]) + 0.7 * xi"), "diverge"),
)
BIASED = LIST.replace("{distance} <= seuil", "{distance} + 1e-3 <= seuil")


@pytest.mark.parametrize(
    ("exercise", "source", "name"),
    one_in(
        3,
        [
            (BOUCLES, submission("np.argsort(scan)"), "secteurs_fixes"),
            (BOUCLES, submission("np.sort(scan[:18])"), "secteurs_fixes"),
            (BOUCLES, submission("np.sort(scan[1:])"), "rayon_oublie"),
            (BOUCLES, submission("np.abs(np.fft.rfft(scan[:-1]))"), "rayon_oublie"),
            (BOUCLES, submission("[np.dot(scan, np.arange(36))]"), "secteurs_fixes"),
            (BOUCLES, submission("[scan.mean(), scan[0]]"), "secteurs_fixes"),
            (BOUCLES, submission("np.sort(np.abs(np.diff(scan)))"), "bouts_a_part"),
            (BOUCLES, submission("np.sort(np.gradient(scan))"), "bouts_a_part"),
            (BOUCLES, submission("np.sort(np.convolve(scan, np.ones(3), 'same'))"), "secteurs_fixes"),
            (BOUCLES, submission("[1.0, *(scan / scan.mean())]"), "secteurs_fixes"),
            (BOUCLES, submission("scan + np.roll(scan, 1)"), "scan_brut"),
            (BOUCLES, submission("np.sort(scan)", body=NEAREST), "plus_proche_seul"),
            (BOUCLES, submission("np.sort(scan)", body=BIASED), None),
            (BOUCLES, submission("np.sort(scan) + rng.normal(0, 1, 36)"), "hasard"),
            (BOUCLES, submission(BOXES, "abs(np.max(a) - np.max(b))"), None),
            (BOUCLES, submission(BOXES, "abs(np.sum(a) - np.sum(b))"), None),
            (BOUCLES, submission("np.array([np.sum(np.histogram(scan)[0])])"), "signature_constante"),
            (BOUCLES, submission("np.unique(scan)[::-1]"), "doublons_retires"),
            (BOUCLES, submission("sorted(set(scan.round(1).tolist()))"), "doublons_retires"),
            (KABSCH, ARCTAN, "angle_modulo_pi"),
            (KABSCH, model_with(KABSCH, *IDENTITY_FOR_A_MIRROR), "symetrie_abandonnee"),
            (PREDIRE, model_with(PREDIRE, "0.8, du, dv", "rng.choice([0.8, 0.7]), du, dv"), "hasard"),
            (PREDIRE, model_with(PREDIRE, *OVERWRITTEN), "ecrasement"),
            (PREDIRE, model_with(PREDIRE, *OVERWRITTEN, *DIVIDED), "ecrasement"),
            (COMB, ROUNDED, "peigne_fige"),
            (SLAM, model_with(SLAM, "range(n_iter)", "range(min(n_iter, 2))"), None),
            *AWAY,
        ],
    ),
)
def test_a_rule_names_what_it_speaks_of(exercise: str, source: str, name: str | None) -> None:
    assert named(plain_verdict_of(exercise, source, 3)) == name


def test_what_is_found_in_one_function_accuses_no_other() -> None:
    """Raw scans compared: the signature is right, whatever the walks confuse."""
    source = model_with(BOUCLES, "signature(scans[j]) - reference", "scans[j] - scans[i]")
    for seed in range(2026, 2030):
        found = plain_verdict_of(BOUCLES, source, seed).diagnosis
        assert found is not None
        assert found.title == "Les scans sont comparés sans passer par la signature"


def test_what_is_kept_between_calls_is_not_said_to_be_random_besides() -> None:
    found = plain_verdict_of(BOUCLES, KEEPING, 3).diagnosis
    assert found is not None
    assert found.title == SLIPS["memoire"].title


ONE_ARRAY = """
rendu = np.zeros(3)

def ramener(t):
    return np.pi - (np.pi - t) % (2 * np.pi)

def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    rendu[:] = a[0] + b[0] * c - b[1] * s, a[1] + b[0] * s + b[1] * c, ramener(a[2] + b[2])
    return rendu

def inverse(a):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([-a[0] * c - a[1] * s, a[0] * s - a[1] * c, ramener(-a[2])])

def relatif(a, b):
    return composer(inverse(a), b)
"""


def test_a_result_that_the_next_call_changes_is_told() -> None:
    found = plain_verdict_of("l20/poses", ONE_ARRAY, 3)
    assert [check.id for check in found.checks if not check.passed] == ["arguments"]
    assert named(found) == "resultat_partage"
    kept_apart = ONE_ARRAY.replace("return rendu", "return rendu.copy()")
    assert plain_verdict_of("l20/poses", kept_apart, 3).points == 20.0


def test_the_words_of_frozen_copies_hold_without_a_comb() -> None:
    found = plain_verdict_of(COMB, ROUNDED, 3).diagnosis
    assert found is not None
    assert found.title == "Les mêmes copies à chaque appel"
