"""What both functions are asked by hand. A signature is free: it is judged by what it does with scans made for it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from graders.core.code.probes import (
    ProbeAnswer,
    ProbeResults,
    Probes,
    ProgramTrial,
    experiment_rule,
    measurement_rule,
    to_finite_array,
    undo_rule,
)
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array, read_indices
from graders.l20 import world
from graders.l20.boucles.asked import AKIN, AT_END, LOOKED, MIDDLE, REPEATED, SAME, SIGNED, TIED, TINY, TURNED, A
from graders.l20.boucles.readings import Unsuitable, is_complex, is_mask, read_signature
from graders.l20.boucles.trials import RAMP


def read_found(args: Arguments, value: Value) -> Value:
    """The indices; in words what are none."""
    try:
        indices = read_indices(value)
    except UnreadableError:
        try:
            array = read_array(value)
        except UnreadableError as error:
            return str(error)
        return ["nombres", array] if array.ndim == 1 else f"forme {array.shape}"
    return ["masque", *indices] if is_mask(value) else np.array(indices, dtype=float)


def read_signed(args: Arguments, value: Value) -> Value:
    """The signature; the mistake in a word when it is none."""
    reading = read_signature(value)
    if isinstance(reading, Unsuitable):
        return reading.word
    return [is_complex(value), reading]


def _signatures(shown: ProbeResults) -> list[Floats] | None:
    """All of the signatures, of one length, or None."""
    found = [one[1] for one in shown.got if isinstance(one, list)]
    return found if len(found) == len(shown.got) and len({one.shape for one in found}) == 1 else None


def _equal(one: Floats, other: Floats) -> bool:
    return bool(np.allclose(one, other, rtol=1e-7, atol=1e-7))


def _invariant(signatures: list[Floats]) -> bool:
    return all(_equal(signatures[0], signatures[k]) for k in SAME)


@undo_rule
def starts_at_an_extreme(shown: ProbeResults) -> str | None:
    """The same for all shifts of a scan without ties, not for those of a scan with."""
    found = _signatures(shown)
    if found is None or not _invariant(found):
        return None
    return None if all(_equal(found[TIED[0]], found[k]) for k in TIED) else "depart_sur_un_extreme"


@measurement_rule
def repeats_dropped(shown: ProbeResults) -> str | None:
    """It ignores the heading, is shorter where distances come again, and the same however often each comes."""
    found = [one[1] for one in shown.got if isinstance(one, list)]
    if len(found) < len(shown.got) or any(
        found[group[0]].shape != found[k].shape for group in (SAME, TIED) for k in group
    ):
        return None
    narrow, wide = (found[k] for k in REPEATED)
    if not narrow.size < found[TIED[0]].size < found[0].size or narrow.shape != wide.shape or not _equal(narrow, wide):
        return None
    same = _invariant(found) and all(_equal(found[TIED[0]], found[k]) for k in TIED)
    return "doublons_retires" if same else None


@measurement_rule
def single_number(shown: ProbeResults) -> str | None:
    """One number, the same for all shifts."""
    found = _signatures(shown)
    if found is None or found[0].size != 1 or not _invariant(found) or _equal(found[0], found[3]):
        return None
    values = np.array([one[0] for one in found])
    means, longest = (np.array([f(args[0]) for args in shown.calls]) for f in (np.mean, np.max))
    if _equal(values, means) or _equal(values, 36.0 * means):
        return "moyenne_seule"
    return "rayon_le_plus_long" if _equal(values, longest) else "un_seul_nombre"


@measurement_rule
def one_ray_forgotten(shown: ProbeResults) -> str | None:
    """The ray at an end of the scan never counts, whatever it measures; the 35 others do, wherever they start from."""
    found = _signatures(shown)
    if found is None or _invariant(found) or found[0].size < 2 or _equal(found[0], found[MIDDLE]):
        return None
    blind = [all(_equal(found[0], found[k]) for k in places) for places in AT_END.values()]
    return "rayon_oublie" if blind.count(True) == 1 else None


@measurement_rule
def single_ray(shown: ProbeResults) -> str | None:
    """One number: what one ray measures, always the same ray."""
    found = _signatures(shown)
    if found is None or found[0].size != 1:
        return None
    scans = np.array([args[0] for args in shown.calls])
    same = np.all(np.abs(scans - np.array(found)) < 1e-9, axis=0)
    return "premier_rayon" if np.any(same) else None


@measurement_rule
def keeps_the_order(shown: ProbeResults) -> str | None:
    """Thirty-six numbers, which a shift of the scan shifts as much."""
    found = _signatures(shown)
    if found is None or _invariant(found) or found[0].size != len(RAMP):
        return None
    return "scan_brut" if all(_equal(np.roll(found[0], k), found[n]) for n, k in ((1, 1), (2, 9))) else None


@measurement_rule
def fourier_without_modulus(shown: ProbeResults) -> str | None:
    """The coefficients of Fourier themselves, their real parts or their arguments: all, or some that follow."""
    found = _signatures(shown)
    if found is None or _invariant(found):
        return None
    got, spectra = np.array(found), np.fft.fft(np.array([args[0] for args in shown.calls]), axis=1)
    complex_ = any(one[0] for one in shown.got)
    size = got.shape[1] // 2 if complex_ else got.shape[1]
    for first in range(3 if 2 <= size <= len(RAMP) else 0):
        part = spectra[:, first : first + size]
        if complex_:
            if _proportional(got, np.hstack([part.real, part.imag])):
                return "fft_sans_module"
        elif part.shape != got.shape:
            continue
        elif _proportional(got, part.real) or _proportional(got, np.abs(part.real)):
            return "partie_reelle"
        elif np.allclose(np.exp(1j * got), np.exp(1j * np.angle(part)), atol=1e-6):
            return "phase_de_fourier"
    return None


def _proportional(got: Floats, known: Floats) -> bool:
    """Is it always the same number of times the other?"""
    if got.shape != known.shape:
        return False
    times = float(np.sum(got * known) / np.sum(known**2))
    return times != 0.0 and bool(np.allclose(got, times * known, atol=1e-7 * float(np.max(np.abs(got)))))


@measurement_rule
def same_for_all(shown: ProbeResults) -> str | None:
    """Always the same numbers, which are not those of a file that nobody has begun to fill in."""
    found = _signatures(shown)
    same = found is not None and all(_equal(found[0], one) for one in found)
    return "signature_constante" if same and found is not None and np.any(found[0] != 0.0) else None


def _ramp_over_the_ends() -> list[Arguments]:
    """Scans whose first and last rays differ as all neighbours around them, turned so that all of these come first."""
    k = np.arange(len(RAMP))
    slopes = []
    for low, step in ((2.0, 0.25), (7.5, -0.2)):
        scan = 4.0 + 2.0 * np.cos(1.7 * k**1.3)
        scan[np.arange(-8, 8)] = low + step * np.arange(16)
        slopes += [(np.roll(scan, turn),) for turn in (0, -5, -2, 1, 4, 6)]
    return slopes


def is_the_same_where_neighbours_differ_alike(trial: ProgramTrial) -> bool:
    """Does the signature ignore the heading where the last and the first ray differ as their neighbours do?"""
    asked = _ramp_over_the_ends()
    found = [one[1] for one in trial.ask(asked) if isinstance(one, list)]
    if len(found) < len(asked) or len({one.shape for one in found}) > 1:
        return False
    half = len(asked) // 2
    same = all(_equal(found[first], one) for first in (0, half) for one in found[first : first + half])
    return same and not _equal(found[0], found[half])


@experiment_rule(is_the_same_where_neighbours_differ_alike)
def leaves_the_ends_apart(shown: ProbeResults) -> str | None:
    found = _signatures(shown)
    return None if found is None or _invariant(found) else "bouts_a_part"


@measurement_rule
def follows_the_heading(shown: ProbeResults) -> str | None:
    """A shift changes it: what no better known mistake explains."""
    found = _signatures(shown)
    return None if found is None or _invariant(found) else "secteurs_fixes"


def _indices(seen: ProbeAnswer) -> list[int] | None:
    found = to_finite_array(seen)
    return None if found is None or found.ndim != 1 else [int(one) for one in found]


@measurement_rule
def unsorted(shown: ProbeResults) -> str | None:
    """The right indices, in another order."""
    pairs = [(_indices(one), _indices(other)) for one, other in zip(shown.got, shown.right, strict=True)]
    if any(one is None or other is None or sorted(one) != other for one, other in pairs):
        return None
    return "plus_proche_d_abord"


@undo_rule
def more_with_less(shown: ProbeResults) -> str | None:
    """A huge threshold finds nothing, a tiny one other places and no other thing."""
    tiny, huge, same = _indices(shown.got[0]), _indices(shown.got[1]), _indices(shown.right[0])
    return "comparaison_a_l_envers" if tiny and huge == [] and not set(tiny) & set(same or ()) else None


@measurement_rule
def threshold_unused(shown: ProbeResults) -> str | None:
    """What a tiny and a huge threshold find is the same: some scans, and more than one."""
    tiny, huge = _indices(shown.got[0]), _indices(shown.got[1])
    return "seuil_ignore" if tiny is not None and tiny == huge and 1 < len(tiny) < 14 else None


@undo_rule
def breaks_off(shown: ProbeResults) -> str | None:
    """What is right until the first scan that is not to be found, or the first after one that is; no more."""
    pairs = [(_indices(one), _indices(other)) for one, other in zip(shown.got, shown.right, strict=True)]
    known = [(one, other) for one, other in pairs if one is not None and other is not None]
    if len(known) < len(pairs) or all(one == other for one, other in known):
        return None
    before = all(one == _run(other, 0) for one, other in known)
    after = all(one == _run(other, other[0] if other else 0) for one, other in known)
    return "boucle_interrompue" if before or after else None


def _run(indices: list[int], start: int) -> list[int]:
    """Those that follow one another from `start` on."""
    return [j for k, j in enumerate(indices) if j == start + k]


@measurement_rule
def window_only(shown: ProbeResults) -> str | None:
    """A huge threshold finds a wrong row of scans, and a tiny one those of them that are of the right place."""
    (scans, i, _), tiny, huge = shown.calls[0], _indices(shown.got[0]), _indices(shown.got[1])
    if tiny is None or not huge or huge == _indices(shown.right[1]) or any(b != a + 1 for a, b in pairwise(huge)):
        return None
    if not 0 <= huge[0] <= huge[-1] < len(scans):
        return None
    return "fenetre_fausse" if tiny == [j for j in huge if np.array_equal(scans[j], scans[i])] else None


@measurement_rule
def distances_instead(shown: ProbeResults) -> str | None:
    """With a huge threshold, one number for each scan of the window: a zero for those of the same place."""
    seen, same, window = shown.got[1], to_finite_array(shown.right[0]), to_finite_array(shown.right[1])
    huge = to_finite_array(seen[1]) if isinstance(seen, list) and seen[0] == "nombres" else None
    if huge is None or same is None or window is None or huge.shape != window.shape:
        return None
    return "distances_renvoyees" if np.sum(np.abs(huge) <= TINY) == len(same) else None


@undo_rule
def raw_scans(shown: ProbeResults) -> str | None:
    """Scans that were turned are not found, the others are."""
    found, right = _indices(shown.got[0]), _indices(shown.right[0])
    scans = shown.calls[0][0]
    if found is None or right is None:
        return None
    return "scans_compares_bruts" if found == [j for j in right if np.array_equal(scans[j], A)] else None


@undo_rule
def compared_badly(shown: ProbeResults) -> str | None:
    """What is found, and should not be: the place of the same norm, or all that are lower, or higher; no other.

    Whoever takes lower places for the same does not take a higher one for it: from a lower place A is not found, from
    a higher one it is. A distance that is the same both ways, and finds these by chance, gets no name.
    """
    found, right = _indices(shown.got[0]), _indices(shown.right[0])
    if found is None or right is None or not set(right) <= set(found):
        return None
    from_lower, from_higher = (0 in (_indices(one) or ()) for one in shown.got[1:3])
    extra = sorted(set(found) - set(right))
    match extra, from_lower, from_higher:
        case [7], False, False:
            return "normes_comparees"
        case ([1, 2, 3], False, True) | ([4, 5, 6], True, False):
            return "plus_grand_ecart_signe"
    return None


PROBES = (
    Probes(
        function="signature",
        calls=SIGNED,
        kit=world.STILL,
        read=read_signed,
        compared=0,
        rules=(
            starts_at_an_extreme,
            repeats_dropped,
            single_number,
            same_for_all,
            single_ray,
            keeps_the_order,
            fourier_without_modulus,
        ),
        last_rules=(one_ray_forgotten, leaves_the_ends_apart, follows_the_heading),
    ),
    Probes(
        function="candidats_boucle",
        calls=LOOKED,
        unique=False,
        kit=world.STILL,
        read=read_found,
        rules=(distances_instead, unsorted, more_with_less, threshold_unused, breaks_off, window_only),
    ),
    Probes(
        function="candidats_boucle",
        calls=TURNED,
        kit=world.STILL,
        read=read_found,
        compared=0,
        unless=frozenset({"signature"}),
        rules=(raw_scans,),
    ),
    Probes(
        function="candidats_boucle",
        calls=AKIN,
        kit=world.STILL,
        read=read_found,
        compared=0,
        unless=frozenset({"signature"}),
        last_rules=(compared_badly,),
    ),
)
