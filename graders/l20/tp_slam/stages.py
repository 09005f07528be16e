"""The stages of the chain on the simulated journey: what each must come to, measured on honest programs."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare.comparison import unreadable
from graders.core.contract.program import StudentFault
from graders.core.contract.values import Floats, UnreadableError, Value, read_array, read_indices, read_scalar
from graders.l20 import parcours
from graders.l20.tp_slam import journeys
from graders.l20.tp_slam.chain import (
    KEY_DISTANCE,
    KEY_TURN,
    Chain,
    Loop,
    ate,
    chain_of,
    steps_of,
    truth_at,
)
from graders.l20.tp_slam.pictures import FAR, match_figure
from graders.l20.tp_slam.told import centimetres, given_up, metres
from reference.odometry import DifferentialDrive, integrate_poses
from reference.se2 import relative, wrap_angle

SAME = 1e-6
#: A match is good within so much of the truth, in metres and radians; the course's miss by 0.028 at most.
NEAR, NEAR_TURN = 0.10, 0.06
GOOD_MATCHES = 0.9
#: In metres: odometry alone comes to 0.58, the matches to 0.19, the graph to 0.10.
MATCHED, SOLVED = 0.40, 0.15
TRUE_LOOP, TRUE_LOOP_TURN = 0.25, 0.15
LEAST_LOOPS, GAP = 35, 20


def read_poses(bench: Bench, function: str, value: Value, count: int) -> Floats:
    """An answer as `count` poses. Raises Rejection."""
    try:
        poses = read_array(value)
    except UnreadableError as error:
        raise given_up(bench, function, unreadable(error)) from error
    if poses.shape != (count, 3) or not np.all(np.isfinite(poses)):
        bench.observe(function, None, ok=False)
        raise Rejection(
            f"{function} doit renvoyer {count} poses, un tableau de forme ({count}, 3) sans nan ni infini.",
            inputs={},
            expected=f"forme ({count}, 3)",
            got=f"forme {poses.shape}" if poses.shape != (count, 3) else "des nombres qui n’en sont pas",
        )
    return poses


def _right_so_far(count: int) -> str:
    return "La pose 0 est juste" if count == 1 else f"Les {count} premières poses sont justes"


def odometry(bench: Bench) -> None:
    """The path that the wheels count, pose by pose."""
    run, chain = journeys.simulated(), chain_of(bench)
    wanted = integrate_poses(DifferentialDrive(parcours.TRACK), run.wheels)
    got = read_poses(bench, "trajectoire", bench.call("trajectoire", run.wheels, parcours.TRACK), len(wanted))
    apart = np.column_stack([got[:, :2] - wanted[:, :2], wrap_angle(got[:, 2] - wanted[:, 2])])
    wrong = np.flatnonzero(np.abs(apart).max(axis=1) > SAME)
    bench.observe("trajectoire", len(wrong), ok=not len(wrong))
    if len(wrong):
        k = int(wrong[0])
        raise Rejection(
            f"{_right_so_far(k)}, la pose {k} ne l’est plus." if k else "Dès la première, les poses sont fausses.",
            inputs={"roues (les dernières lues)": run.wheels[max(0, k - 1) : k], "L": parcours.TRACK},
            expected=wanted[k],
            got=got[k],
        )
    chain.own.odometry = got


def key_poses(bench: Bench) -> None:
    """Neither too early nor too late, whatever is meant by « parcouru »: along the path, or as the crow flies."""
    chain = chain_of(bench)
    poses = chain.odometry
    try:
        keys = read_indices(bench.call("poses_cles", poses))
    except UnreadableError as error:
        raise given_up(bench, "poses_cles", unreadable(error)) from error
    fault = _fault_of_keys(poses, keys)
    bench.observe("poses_cles", len(keys), ok=not fault)
    if fault:
        raise Rejection(
            fault, inputs={"poses": f"l’odométrie du parcours, {len(poses)} poses"}, expected="136 indices environ, "
            "croissants, à partir de 0", got=keys[:12],
        )  # fmt: skip
    chain.own.keys = keys


def _fault_of_keys(poses: Floats, keys: list[int]) -> str:
    if not keys or keys[0] != 0:
        return "La première pose est toujours une pose clé : l’indice 0 doit venir en tête."
    if any(not a < b < len(poses) for a, b in itertools.pairwise(keys)):
        return f"Les indices doivent croître strictement et rester sous {len(poses)}."
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T)))
    turned = np.append(0.0, np.cumsum(np.abs(wrap_angle(np.diff(poses[:, 2])))))
    for a, b in zip(keys, [*keys[1:], len(poses)], strict=True):
        if b < len(poses) and along[b] - along[a] < KEY_DISTANCE - SAME and turned[b] - turned[a] < KEY_TURN - SAME:
            return f"De {a} à {b}, le robot n’a fait ni 30 cm ni 0,4 rad : l’indice {b} vient trop tôt."
        x, y, theta = relative(poses[a], poses[b - 1])
        if b - 1 > a and (np.hypot(x, y) > KEY_DISTANCE + SAME or abs(theta) > KEY_TURN + SAME):
            return f"Dès l’indice {b - 1}, le robot avait fait 30 cm ou tourné de 0,4 rad depuis {a} : il en faut un."
    return ""


def matching(bench: Bench) -> None:
    """Each key scan on the one before, from what odometry says."""
    chain = chain_of(bench)
    moves, truth = steps_of(chain.odometry[chain.keys]), steps_of(truth_at(chain.keys))
    clouds = [journeys.cloud(journeys.simulated().scans[k]) for k in chain.keys]
    found, parts = matched(bench, [(clouds[k], clouds[k + 1], moves[k]) for k in range(len(moves))])
    missed = relative(truth, found)
    near = (np.hypot(missed[:, 0], missed[:, 1]) < NEAR) & (np.abs(missed[:, 2]) < NEAR_TURN)
    error = ate(journeys.added_up(found), truth_at(chain.keys))
    well = bool(near.mean() >= GOOD_MATCHES and error < MATCHED)
    bench.observe("recaler", round(float(near.mean()), 1), ok=well)
    if not well:
        k = int(np.argmax(np.hypot(missed[:, 0], missed[:, 1]) + 0.3 * np.abs(missed[:, 2])))
        raise Rejection(
            f"Sur {len(moves)} recalages, {int(np.sum(~near))} se trompent de plus de 10 cm ou 0,06 rad ; mis bout à "
            f"bout, leur ATE est de {metres(error)}. Le pire va de la pose clé {k} à la suivante.{borrowed(chain)}",
            inputs={"depart (ce que dit l’odométrie)": moves[k], "points_a": f"{len(clouds[k])} points", "points_b":
                    f"{len(clouds[k + 1])} points"},
            expected=truth[k],
            got=found[k],
            figure=match_figure(clouds[k], clouds[k + 1], truth[k], found[k], moves[k]),
        )  # fmt: skip
    if not (0.75 <= float(np.mean(parts)) <= 1.0 and min(parts) >= 0.0 and max(parts) <= 1.0):
        raise Rejection(
            "Les poses sont bonnes, mais la part des points qui trouvent un voisin à moins de 10 cm ne l’est pas : "
            f"elle vaut ici {float(np.mean(parts)):.2f} en moyenne.".replace(".", ",", 1),
            inputs={"recalages": len(moves)},
            expected="0,93 en moyenne, jamais moins de 0,7",
            got=[round(min(parts), 3), round(max(parts), 3)],
        )
    bench.measured = f"Vos {len(found)} recalages, mis bout à bout, ont une ATE de {metres(error)}."
    chain.own.matches = found


def matched(bench: Bench, calls: list[tuple[Floats, Floats, Floats]]) -> tuple[Floats, list[float]]:
    """The pose and the share of each call of `recaler`. Raises Rejection, StudentFault."""
    found, parts = [], []
    for _, answer in bench.call_many("recaler", calls, faults=1):
        if isinstance(answer, BaseException):
            raise answer
        try:
            if not isinstance(answer.value, list | tuple) or len(answer.value) != 2:
                raise UnreadableError("la fonction doit renvoyer deux valeurs, (pose, part)")
            pose, part = read_array(answer.value[0]), read_scalar(answer.value[1])
            if pose.shape != (3,) or not (np.all(np.isfinite(pose)) and np.isfinite(part)):
                raise UnreadableError("la fonction doit renvoyer une pose (3,) et un nombre, finis")
        except UnreadableError as error:
            raise given_up(bench, "recaler", unreadable(error)) from error
        found.append(pose)
        parts.append(part)
    return np.array(found), parts


def closing(bench: Bench) -> None:
    """Places seen again: enough of them, and not one that is false."""
    chain = chain_of(bench)
    keys, matches = chain.matched()
    start, truth = journeys.added_up(matches), truth_at(keys)
    loops = read_loops(bench, bench.call("fermetures", journeys.simulated().scans[keys], start), len(start))
    missed = np.array([relative(relative(truth[a], truth[b]), z) for a, b, z in loops]).reshape(-1, 3)
    false = (np.hypot(missed[:, 0], missed[:, 1]) > TRUE_LOOP) | (np.abs(missed[:, 2]) > TRUE_LOOP_TURN)
    close = np.array([abs(a - b) < GAP for a, b, _ in loops], dtype=bool)
    pairs = len({frozenset(loop[:2]) for loop in loops})
    well = pairs >= LEAST_LOOPS and not false.any() and not close.any()
    bench.observe("fermetures", [bool(false.any()), bool(close.any()), pairs >= LEAST_LOOPS], ok=well)
    if close.any():
        a, b, _ = loops[int(np.argmax(close))]
        raise _refused(
            f"Les poses clés {a} et {b} sont voisines sur le chemin : il faut au moins vingt rangs entre elles.",
            chain, loops, f"des paires distantes de {GAP} rangs",
        )  # fmt: skip
    if false.any():
        k = int(np.argmax(false))
        a, b, _ = loops[k]
        away = centimetres(float(np.hypot(*missed[k, :2])))
        raise _refused(
            f"{int(false.sum())} fermeture(s) sur {len(loops)} sont fausses. La première relie {a} à {b}, et se trompe "
            f"de {away} : une seule suffit à tordre la carte.", chain, loops, "aucune fausse fermeture",
        )  # fmt: skip
    if not well:
        raise _refused(
            f"{pairs} fermeture(s) seulement : le robot refait pourtant toute une boucle.", chain, loops,
            f"au moins {LEAST_LOOPS}, 71 d’après le TP",
        )  # fmt: skip
    bench.measured = f"{pairs} fermetures, et aucune fausse."
    chain.own.loops = loops


def _refused(message: str, chain: Chain, loops: list[Loop], expected: str) -> Rejection:
    return Rejection(
        message + borrowed(chain),
        inputs={"poses clés": len(chain.matched()[0])},
        expected=expected,
        got=[[a, b, *np.round(z, 3).tolist()] for a, b, z in loops[:3]],
    )


def read_loops(bench: Bench, value: Value, count: int) -> list[Loop]:
    """An answer as loops between `count` key poses. Raises Rejection."""
    try:
        if not isinstance(value, list | tuple):
            raise UnreadableError("la fonction doit renvoyer une liste de triplets (a, b, pose)")
        return [_read_loop(one, count) for one in value]
    except UnreadableError as error:
        raise given_up(bench, "fermetures", unreadable(error)) from error


def _read_loop(value: Value, count: int) -> Loop:
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise UnreadableError("chaque fermeture doit être un triplet (a, b, pose de b vue de a)")
    (a, b), pose = read_indices([value[0], value[1]]), read_array(value[2])
    if not (0 <= a < count and 0 <= b < count) or pose.shape != (3,) or not np.all(np.isfinite(pose)):
        raise UnreadableError("une fermeture relie deux poses clés par une pose (3,) finie")
    return a, b, pose


def solving(bench: Bench) -> None:
    """The graph of all that: odometry, matches, loops."""
    chain = chain_of(bench)
    keys, matches, loops = chain.closed()
    start, got = _solved(bench, chain, keys, matches, loops)
    truth = truth_at(keys)
    before, after = ate(start, truth), ate(got, truth)
    bench.observe("optimiser", after < SOLVED, ok=after < SOLVED)
    if after >= SOLVED:
        raise Rejection(
            f"Le graphe devrait ramener l’ATE de {metres(before)} à {metres(0.10)} environ ; elle vaut "
            f"{metres(after)}.{borrowed(chain)}",
            inputs={"poses clés": len(start), "recalages": len(matches), "boucles": len(loops)},
            expected=f"une ATE sous {metres(SOLVED)}",
            got=f"une ATE de {metres(after)}",
        )
    bench.measured = f"L’ATE passe de {metres(before)} à {metres(after)}.{borrowed(chain)}"
    chain.own.poses, chain.own.solved_keys = got, keys


def show_solved(bench: Bench) -> None:
    """Leave the film of the whole journey where a small graph has failed: nothing is judged."""
    with suppress(Rejection, StudentFault):
        chain = chain_of(bench)
        _solved(bench, chain, *chain.closed(), unjudged=True)


def _solved(
    bench: Bench, chain: Chain, keys: list[int], matches: Floats, loops: list[Loop], *, unjudged: bool = False
) -> tuple[Floats, Floats]:
    """The chain (k, 3) of the matches and what `optimiser` makes of it, filmed. Raises Rejection, StudentFault."""
    counted = chain.odometry[keys]
    moves, start = steps_of(counted), journeys.added_up(matches)
    got = read_poses(bench, "optimiser", bench.call("optimiser", start, matches, moves, loops), len(start))
    film(bench, "simule", counted, start, loops, got, keys, borrows=chain.borrowed, unjudged=unjudged)
    return start, got


def film(
    bench: Bench,
    place: str,
    odometry: Floats,
    start: Floats,
    loops: Sequence[Loop] = (),
    solved: Floats | None = None,
    keys: Sequence[int] = (),
    before: Floats | None = None,
    borrows: bool = False,
    unjudged: bool = False,
) -> None:
    """Leave what the stages have come to: poses of the key scans, and the loops by their ends.

    `solved`: None where the matches did not get that far. `before`: what matches came to from odometry that was not yet
    calibrated. `borrows`: it began with results of the course. `unjudged`: it is another case that has failed.
    """
    paths = {"before": before, "odometry": odometry, "matched": start, "solved": solved}
    bench.record_film(
        {name: np.round(np.clip(path, -FAR, FAR), 3) for name, path in paths.items() if path is not None}
        | {
            "kind": "chaine",
            "place": place,
            "borrowed": borrows,
            "unjudged": unjudged,
            "keys": list(keys),
            "loops": [[a, b] for a, b, _ in loops][:400],
        }
    )


def borrowed(chain: Chain) -> str:
    """Said where a stage began with what an earlier one of the course gave."""
    if not chain.borrowed:
        return ""
    return " (Une étape d’avant n’a pas réussi : celle-ci est partie des résultats du cours.)"
