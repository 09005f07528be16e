"""l20/poses: composing, inverting and comparing poses of the plane (course exercise 3)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from graders.core.code.at_once import value_of
from graders.core.code.bench import Bench
from graders.core.code.checks import Cases, Rejection, Trial, Untouched
from graders.core.code.exercise import code
from graders.core.compare import words as render
from graders.core.contract.findings import FigureData
from graders.core.contract.program import Answer, Foreseen
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20 import world
from graders.l20.poses.probes import PROBES
from graders.robotics.poses import SamePose, shrink_pose
from reference.se2 import compose, inverse, relative

QUARTER = math.pi / 2
IS_POSE = SamePose(tolerance=math.inf)
ON_BOTH_SIDES = SamePose(tolerance=1e-8)


def pose(x: float, y: float, theta: float) -> Floats:
    return np.array([x, y, theta], dtype=np.float64)


def random_poses(rng: np.random.Generator, count: int, reach: float = 10.0) -> Floats:
    """Poses (count, 3) with x, y in [-reach, reach] and theta in [-pi, pi]."""
    limits = pose(reach, reach, math.pi)
    return np.asarray(-limits + 2.0 * limits * rng.random((count, 3)))


def random_pose(rng: np.random.Generator, reach: float = 10.0) -> Floats:
    return np.asarray(random_poses(rng, 1, reach)[0])


def simple_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    """Whole numbers and quarter turns whose sum stays within half a turn.

    The first call turns: a program that keeps its first rotation would otherwise look like one that forgets it.
    """
    yield pose(1, 2, QUARTER), pose(1, 0, 0)
    yield pose(0, 0, 0), pose(1, 2, QUARTER)
    yield pose(1, 2, 0), pose(3, 0, 0)
    yield pose(1, 2, QUARTER), pose(3, 1, -QUARTER)
    yield pose(0, 0, -QUARTER), pose(1, 2, 0)
    for _ in range(4):
        x1, y1, x2, y2 = rng.integers(-4, 5, 4)
        yield pose(x1, y1, -QUARTER), pose(x2 or 1, y2 or 2, float(rng.choice([0.0, QUARTER])))


def random_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    """Any two poses whose angles add up, and subtract, to less than half a turn: first to more than a quarter."""
    yield pose(1.5, -2.25, 1.2), pose(0.75, 2.5, 0.9)
    yield pose(-3.5, 1.25, -0.8), pose(2.75, -1.5, -1.3)
    drawn = random_poses(rng, 24)
    drawn[:, 2] /= 2.1
    yield from zip(drawn[::2], drawn[1::2], strict=True)


def wrapping_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    """Poses whose angles add up to more than half a turn, in both senses."""
    yield pose(0, 0, QUARTER), pose(0, 0, 3 * math.pi / 4)
    yield pose(1, 0, -QUARTER), pose(0, 1, -3 * math.pi / 4)
    yield pose(0, 0, math.pi), pose(1, 0, math.pi)
    for sign in (1, -1, 1, -1):
        a, b = random_pose(rng), random_pose(rng)
        a[2], b[2] = sign * rng.uniform(1.7, 3.1), sign * rng.uniform(1.7, 3.1)
        yield a, b


def single_poses(rng: np.random.Generator) -> Iterator[Arguments]:
    yield (pose(1, 0, QUARTER),)
    yield (pose(0, 0, 0),)
    yield (pose(1, 2, 0),)
    yield (pose(0, 0, QUARTER),)
    yield (pose(2, 1, -QUARTER),)
    yield (pose(1, 2, math.pi),)
    yield from ((drawn,) for drawn in random_poses(rng, 10))


def relative_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    yield pose(1, 2, QUARTER), pose(1, 3, QUARTER)
    yield pose(1, 2, 0), pose(1, 2, 0)
    yield pose(1, 2, 0), pose(3, 5, QUARTER)
    yield pose(2, 1, -QUARTER), pose(0, 1, 0)
    drawn = random_poses(rng, 20)
    yield from zip(drawn[::2], drawn[1::2], strict=True)
    for sign in (1, -1):
        yield pose(1, 1, 3.0 * sign), pose(-2, 4, -3.0 * sign)


def wraps(args: Arguments) -> bool:
    """Does the sum of the angles leave ]-pi, pi]?"""
    return bool(abs(args[0][2] + args[1][2]) > math.pi + 1e-6)


def stays(args: Arguments) -> bool:
    return not wraps(args)


def in_the_world(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    """The answer of `composer` beside a, in the frame of the world (b is given in another one)."""
    frames = {"monde": pose(0, 0, 0), "a": args[0]}
    return {"kind": "frames", "title": "Dans le repère du monde", "frames": frames, "expected": expected, "got": got}


def seen_from_a(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    """The answer of `inverse` or `relatif`, in the frame of a."""
    frames = {"a": pose(0, 0, 0)}
    return {"kind": "frames", "title": "Dans le repère de a", "frames": frames, "expected": expected, "got": got}


def identity_calls(bench: Bench) -> Sequence[Foreseen]:
    """What the identities ask of what is drawn: poses far round, by hand, then any."""
    triples: list[tuple[Floats, ...]] = [
        (pose(1, 2, 3.0), pose(-2, 1, 2.5), pose(2, 0, -2.8)),
        (pose(-3, 1, -2.7), pose(1, 4, -1.9), pose(0, 2, 3.1)),
        (pose(2, 1, -2.9), pose(-1, 3, 2.6), pose(1, 1, 0.5)),
        (pose(0, -2, 2.8), pose(3, 1, -2.5), pose(1, -1, -0.5)),
    ]
    drawn = random_poses(bench.rng, 15, 5.0).reshape(5, 3, 3)
    triples += [tuple(one) for one in (*np.round(drawn[:2]), *np.round(drawn[2:], 6))]
    return [
        Foreseen("inverse", [(a,) for a, _, _ in triples], faults=1),
        Foreseen("relatif", [(a, b) for a, b, _ in triples], faults=1),
        Foreseen("composer", [(a, b) for a, b, _ in triples], faults=1),
        Foreseen("composer", [(b, c) for _, b, c in triples], faults=1),
    ]


def identities(bench: Bench) -> None:
    """The three identities of the statement, on the student's own functions."""
    asked = bench.foreseen or identity_calls(bench)
    triples = [(a, b, c) for (a, b), (_, c) in zip(asked[2].calls, asked[3].calls, strict=True)]
    sides = _sides(bench, asked, triples)
    if sides is not None and all(ON_BOTH_SIDES.surely(right, left) for left, right in sides):
        for shown in zip(*(left for left, _ in sides), strict=True):
            bench.observe_right("composer", shown)
        return
    call = partial(_pose_or_reject, bench)
    for a, b, c in triples:
        law = "composer(a, inverse(a)) = (0, 0, 0)"
        _hold(bench, law, {"a": a}, call("composer", a, call("inverse", a)), pose(0, 0, 0))
        law = "composer(a, relatif(a, b)) = b"
        _hold(bench, law, {"a": a, "b": b}, call("composer", a, call("relatif", a, b)), b)
        law = "composer(composer(a, b), c) = composer(a, composer(b, c))"
        left = call("composer", call("composer", a, b), c)
        right = call("composer", a, call("composer", b, c))
        _hold(bench, law, {"a": a, "b": b, "c": c}, left, right)


def _sides(
    bench: Bench, asked: Sequence[Foreseen], triples: Sequence[tuple[Floats, ...]]
) -> Sequence[tuple[Floats, Floats]] | None:
    """Both sides (n, 3) of the three identities, for all triples; None where an answer is not a pose.

    All calls are made together: those on what was drawn, then those on the poses that came back.
    """
    inverses, relatives, left, right = (bench.ahead(one) for one in asked)
    outer = [
        *((a, got) for (a, _, _), got in _poses(triples, inverses)),
        *((a, got) for (a, _, _), got in _poses(triples, relatives)),
        *((got, c) for (_, _, c), got in _poses(triples, left)),
        *((a, got) for (a, _, _), got in _poses(triples, right)),
    ]
    found = list(map(_pose_of, bench.ahead(Foreseen("composer", outer, faults=1))))
    if len(found) < 4 * len(triples) or any(one is None for one in found):
        return None
    back, there, one_way, other_way = np.array(found).reshape(4, len(triples), 3)
    return [(back, np.zeros_like(back)), (there, np.array([b for _, b, _ in triples])), (one_way, other_way)]


def _poses(
    triples: Sequence[tuple[Floats, ...]], answers: Sequence[Answer]
) -> Iterator[tuple[tuple[Floats, ...], Floats]]:
    """The triples whose answer is a pose, with it."""
    for triple, answer in zip(triples, answers, strict=False):
        found = _pose_of(answer)
        if found is not None:
            yield triple, found


def _pose_of(answer: Answer) -> Floats | None:
    value = value_of(answer)
    if type(value) is np.ndarray and value.dtype == np.float64 and value.shape == (3,):
        x, y, theta = value.tolist()
        if math.isfinite(x) and math.isfinite(y) and abs(theta) <= math.pi:
            return value
    if value is None or IS_POSE(pose(0, 0, 0), value) is not None:
        return None
    return np.asarray(value, dtype=np.float64)


def _pose_or_reject(bench: Bench, function: str, *args: Value) -> Floats:
    value = bench.call(function, *args)
    mismatch = IS_POSE(pose(0, 0, 0), value)
    if mismatch is not None:
        inputs = dict(zip(NAMES[function], args, strict=True))
        bench.observe(function, value, ok=False)
        raise Rejection(
            f"{function} ne renvoie pas une pose. {mismatch.message}",
            inputs=inputs, expected="une pose (x, y, θ)", got=value, slip=mismatch.slip, cause=mismatch.cause,
        )  # fmt: skip
    return np.asarray(value, dtype=np.float64)


def _hold(bench: Bench, law: str, inputs: dict[str, Value], left: Floats, right: Floats) -> None:
    mismatch = ON_BOTH_SIDES(right, left)
    bench.observe("composer", left, ok=mismatch is None)
    if mismatch is not None:
        raise Rejection(
            f"L'identité {law} n'est pas vérifiée : à gauche {render.text(left)}, à droite {render.text(right)}.",
            inputs=inputs,
            expected=right,
            got=left,
        )


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    a, b = random_pose(rng), random_pose(rng)
    return {"composer": (a, b), "inverse": (a,), "relatif": (a, b)}


PAIR = ("a", "b")
NAMES = {"composer": PAIR, "inverse": ("a",), "relatif": PAIR}
ON_POSES = (shrink_pose, shrink_pose)

CHECKS = (
    Cases(
        id="composer_exemples",
        title="Composer : des nombres entiers et des quarts de tour",
        points=3,
        functions=("composer",),
        names=PAIR,
        cases=simple_pairs,
        expected=compose,
        rows=True,
        compare=SamePose(any_turn=True),
        shrinkers=ON_POSES,
        valid=stays,
        figure=in_the_world,
        hint="Le robot regarde vers le haut (θ = π/2) et avance d'un mètre : laquelle de ses coordonnées change ?",
    ),
    Cases(
        id="composer_hasard",
        title="Composer : des poses au hasard",
        points=3,
        functions=("composer",),
        names=PAIR,
        cases=random_pairs,
        expected=compose,
        rows=True,
        compare=SamePose(any_turn=True),
        shrinkers=ON_POSES,
        valid=stays,
        figure=in_the_world,
        hint="Votre formule emploie-t-elle cos θ₁ et sin θ₁ aux quatre bons endroits, avec les bons signes ?",
    ),
    Cases(
        id="composer_tours",
        title="Composer : l'angle revient dans ]−π, π]",
        points=2,
        functions=("composer",),
        names=PAIR,
        cases=wrapping_pairs,
        expected=compose,
        rows=True,
        compare=SamePose(),
        shrinkers=ON_POSES,
        valid=wraps,
        figure=in_the_world,
        hint="Que vaut θ₁ + θ₂ quand le robot tourne deux fois de 135° ? Comment le ramener dans ]−π, π] ?",
    ),
    Cases(
        id="inverse",
        title="Inverser une pose",
        points=4,
        functions=("inverse",),
        names=("a",),
        cases=single_poses,
        expected=inverse,
        rows=True,
        compare=SamePose(),
        shrinkers=(shrink_pose,),
        figure=seen_from_a,
        hint="Vu du robot, où se trouve l'origine du monde ? Suffit-il de changer les signes de x et de y ?",
    ),
    Cases(
        id="relatif",
        title="La pose de b vue depuis a",
        points=4,
        functions=("relatif",),
        names=PAIR,
        cases=relative_pairs,
        expected=relative,
        rows=True,
        compare=SamePose(),
        shrinkers=ON_POSES,
        figure=seen_from_a,
        hint="Si a et b sont confondues, que doit valoir relatif(a, b) ? Et si b est un mètre devant a ?",
    ),
    Trial(
        id="identites",
        title="Les trois identités de l'énoncé",
        points=3,
        functions=("composer", "inverse", "relatif"),
        protocol=identities,
        asks=identity_calls,
        hint="Calculez composer(a, inverse(a)) à la main pour a = (1, 0, π/2) : que trouvez-vous ?",
    ),
    Untouched(
        id="arguments",
        title="Les poses données restent intactes",
        points=1,
        functions=("composer", "inverse", "relatif"),
        names=NAMES,
        inputs=arguments_to_keep,
        hint="Faut-il écrire dans le tableau reçu, ou en créer un nouveau ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, kit=world.kit, probes=PROBES)
