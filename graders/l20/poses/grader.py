"""l20/poses: composing, inverting and comparing poses of the plane (course exercise 3)."""

from __future__ import annotations

import numpy as np

from graders.core.code.checks import Cases, Trial, Untouched
from graders.core.code.exercise import code
from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20 import world
from graders.l20.poses import cases
from graders.l20.poses.cases import NAMES, PAIR, pose, random_pose
from graders.l20.poses.contract import CONTRACTS
from graders.l20.poses.identities import identities, identity_calls
from graders.l20.poses.probes import PROBES
from graders.robotics.poses import SamePose, shrink_pose
from reference.se2 import compose, inverse, relative


def in_the_world(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    """The answer of `composer` beside a, in the frame of the world (b is given in another one)."""
    frames = {"monde": pose(0, 0, 0), "a": args[0]}
    return {"kind": "frames", "title": "Dans le repère du monde", "frames": frames, "expected": expected, "got": got}


def seen_from_a(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    """The answer of `inverse` or `relatif`, in the frame of a."""
    frames = {"a": pose(0, 0, 0)}
    return {"kind": "frames", "title": "Dans le repère de a", "frames": frames, "expected": expected, "got": got}


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    a, b = random_pose(rng), random_pose(rng)
    return {"composer": (a, b), "inverse": (a,), "relatif": (a, b)}


ON_POSES = (shrink_pose, shrink_pose)

CHECKS = (
    Cases(
        id="composer_exemples",
        title="Composer : des nombres entiers et des quarts de tour",
        points=3,
        functions=("composer",),
        names=PAIR,
        cases=cases.simple_pairs,
        expected=compose,
        rows=True,
        compare=SamePose(any_turn=True),
        shrinkers=ON_POSES,
        valid=cases.stays,
        figure=in_the_world,
        hint="Le robot regarde vers le haut (θ = π/2) et avance d'un mètre : laquelle de ses coordonnées change ?",
    ),
    Cases(
        id="composer_hasard",
        title="Composer : des poses au hasard",
        points=3,
        functions=("composer",),
        names=PAIR,
        cases=cases.random_pairs,
        expected=compose,
        rows=True,
        compare=SamePose(any_turn=True),
        shrinkers=ON_POSES,
        valid=cases.stays,
        figure=in_the_world,
        hint="Votre formule emploie-t-elle cos θ₁ et sin θ₁ aux quatre bons endroits, avec les bons signes ?",
    ),
    Cases(
        id="composer_tours",
        title="Composer : l'angle revient dans ]−π, π]",
        points=2,
        functions=("composer",),
        names=PAIR,
        cases=cases.wrapping_pairs,
        expected=compose,
        rows=True,
        compare=SamePose(heading_only=True),
        shrinkers=ON_POSES,
        valid=cases.wraps,
        figure=in_the_world,
        hint="Que vaut θ₁ + θ₂ quand le robot tourne deux fois de 135° ? Comment le ramener dans ]−π, π] ?",
    ),
    Cases(
        id="inverse",
        title="Inverser une pose",
        points=4,
        functions=("inverse",),
        names=("a",),
        cases=cases.single_poses,
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
        cases=cases.relative_pairs,
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

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
