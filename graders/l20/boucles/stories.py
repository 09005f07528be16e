"""How a failed search for a threshold is told to the student, and the data of the drawings."""

from __future__ import annotations

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare import words as render
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome as Cause
from graders.core.contract.program import StudentFault
from graders.core.contract.values import Floats, Value
from graders.l20.boucles.calibration import Outcome, Search
from graders.l20.boucles.family import DISTANCES
from graders.l20.boucles.readings import Unsuitable, read_signature

DRAWABLE = 1e12
#: How many times farther than another reading of its place a scan is when a signature tells it apart, by any length.
CLEARLY = 2.0
LENGTHS = tuple(DISTANCES[name] for name in ("L1", "L2", "max"))
LONGEST_DRAWN = 400


def tell(search: Search, remark: str, figure: FigureData | None) -> Rejection:
    """A failed search as a finding: from which scan, with which threshold, which scan is missing or too many."""
    if search.outcome is Outcome.UNREADABLE:
        return Rejection(
            f"candidats_boucle ne convient pas : {search.reason}.",
            inputs={"scans": f"{len(search.walk.scans)} scans", "i": search.query, "seuil": search.threshold},
            expected="une liste d'indices entiers",
            got=search.got,
            cause=Cause.INVALID_OUTPUT,
        )
    return Rejection(
        _sentence(search) + remark,
        inputs=_inputs(search),
        expected=search.walk.same_place(search.query),
        got=list(search.found),
        slip="memoire" if search.outcome is Outcome.REMEMBERS else None,
        figure=figure,
    )


def _sentence(search: Search) -> str:
    i, missed, wrong = search.query, search.missed, search.wrong
    if search.outcome is Outcome.NEVER:
        return (
            f"Depuis le scan {i}, le scan {missed}, pris au même endroit avec un autre cap, n'est pas trouvé, "
            "même avec un seuil immense."
        )
    if search.outcome in (Outcome.REMEMBERS, Outcome.ORDER):
        why = (
            "alors que le même fichier relancé les y trouve : votre fonction se souvient d'appels précédents, ou tire "
            "au hasard."
            if search.outcome is Outcome.REMEMBERS
            else "même en relançant votre fichier : votre résultat dépend du rang des scans, et pas d'eux seuls."
        )
        return (
            f"Avec le seuil {render.number(search.threshold, 3)}, les bons scans étaient trouvés ; on a ensuite rangé "
            f"les mêmes scans dans un autre ordre, et ils ne le sont plus, {why}"
        )
    if search.outcome is Outcome.REVERSED:
        return (
            f"Depuis le scan {i}, un seuil minuscule trouve le scan {wrong}, pris ailleurs, et un seuil immense trouve "
            "moins de scans : plus le seuil est grand, plus il doit y avoir de candidats."
        )
    if search.outcome is Outcome.ALWAYS:
        whence = f"Depuis le scan {search.wrong_from}, le scan {wrong}, pris ailleurs,"
        return f"{whence} est trouvé même avec un seuil minuscule."
    seen_from = "" if search.wrong_from in (None, i) else f" depuis le scan {search.wrong_from}"
    return (
        f"Aucun seuil ne convient. Avec {render.number(search.threshold, 3)}, depuis le scan {i}, le scan {missed} "
        f"(même endroit, autre cap) manque encore, alors que{seen_from} le scan {wrong} (autre endroit) "
        "est déjà trouvé, ou l'est pour un seuil à peine plus grand."
    )


def _inputs(search: Search) -> dict[str, Value]:
    walk, i = search.walk, search.query
    inputs: dict[str, Value] = {f"scan {i}": walk.call(i)}
    if search.missed is not None:
        inputs[f"scan {search.missed} (même endroit)"] = walk.call(search.missed)
    if search.wrong is not None:
        inputs[f"scan {search.wrong} (autre endroit)"] = walk.call(search.wrong)
    return {**inputs, "i": i, "seuil": search.threshold}


def rotation_figure(scan: Floats, shifted: Floats, of_scan: Floats, of_shifted: Floats) -> FigureData:
    """A scan and the same one shifted, with the student's signatures of both."""
    rows = [("le scan", scan, of_scan), ("le même, décalé", shifted, of_shifted)]
    return {
        "kind": "rotation",
        "scans": [{"name": name, "scan": z, "signature": _drawable(s)} for name, z, s in rows],
    }


def places_figure(bench: Bench, search: Search) -> FigureData:
    """The scan asked about, the one missed and the one wrongly found, and where these stand in the walk."""
    walk, i = search.walk, search.query
    here = walk.same_place(i)
    same = search.missed if search.missed is not None else here[0]
    rows = [(f"scan {i}", i), (f"scan {same}, même endroit", same)]
    if search.wrong is not None:
        rows.append((f"scan {search.wrong}, ailleurs", search.wrong))
    scans = [{"name": name, "scan": walk.scans[j], "signature": _asked(bench, walk.scans[j])} for name, j in rows]
    timeline = {"count": len(walk.scans), "query": i, "expected": here, "found": list(search.found)}
    return {"kind": "places", "scans": scans, "timeline": timeline, "threshold": search.threshold}


def comparison(bench: Bench, search: Search) -> str:
    """What the student's own signatures say of two places that were confused, in words; nothing when unsure."""
    if search.outcome not in (Outcome.MIXED, Outcome.ALWAYS) or search.wrong is None:
        return ""
    walk, same = search.walk, min(search.walk.same_place(search.query))
    asked, again, other = (_asked(bench, walk.scans[j]) for j in (search.query, same, search.wrong))
    if asked is None or again is None or other is None or not len(asked) == len(again) == len(other):
        return ""
    reading, place = ([float(d(asked[None], z[None])[0, 0]) for d in LENGTHS] for z in (again, other))
    if all(far > CLEARLY * near for near, far in zip(reading, place, strict=True)):
        return (
            f" Vos signatures les séparent pourtant : celle du scan {search.query} est plus de deux fois plus proche "
            f"de celle du scan {same} (même endroit) que de celle du scan {search.wrong}."
        )
    nearer = any(far < near for near, far in zip(reading, place, strict=True))
    shared = walk.alike.get(search.wrong) if search.outcome is Outcome.MIXED else None
    return f" Ces deux lieux ont {shared}." if nearer and shared else ""


def _asked(bench: Bench, scan: Floats) -> Floats | None:
    try:
        reading = read_signature(bench.call("signature", scan))
    except StudentFault:
        return None
    return None if isinstance(reading, Unsuitable) else _drawable(reading)


def _drawable(signature: Floats) -> Floats | None:
    sane = signature.size <= LONGEST_DRAWN and bool(np.all(np.abs(signature) < DRAWABLE))
    return signature if sane else None
