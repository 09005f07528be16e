"""l20/mcl: Monte Carlo localisation, from the first cloud to the estimate, judged step by step and in closed loop.

Measured on the honest filters of `specimens/ok`: all of 128 tracking runs succeed, where 6 of 8 are needed; if 98 %
did, 4 gradings in 10,000 would refuse one. On the small maps, chosen for it, 94 % of the runs succeed, where 3 of 8 are
needed: at 90 %, 1 grading in 40,000 refuses one. None failed a check of one step in 60 gradings of each.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from graders.core.code.checks import Trial, Untouched
from graders.core.code.exercise import code
from graders.core.code.loops import ClosedLoop
from graders.l20 import world
from graders.l20.mcl import estimates, memory, runs, sowing, steps
from graders.l20.mcl.answers import ESTIMATE, SEED, STEP
from graders.l20.mcl.contract import CONTRACTS
from graders.l20.mcl.probes import PROBES


@dataclass(frozen=True, kw_only=True)
class TrialBeside(Trial):
    """One that a step which does nothing passes."""

    requires_other_check: ClassVar[bool] = True


ONE_STEP = ("forme", "deplacement", "dispersion", "pesee", "immobile")

CHECKS = (
    Trial(
        id="semer",
        title="Semer : partout sur les cases libres, avec tous les caps",
        points=2,
        functions=(SEED,),
        protocol=sowing.sown,
        hint="Dans quel ordre np.argwhere(libres) donne-t-il la ligne et la colonne ? Laquelle est x ?",
    ),
    Trial(
        id="estimer_milieu",
        title="Estimer : le milieu du nuage, même autour de ±π",
        points=2,
        functions=(ESTIMATE,),
        protocol=estimates.averaged,
        hint="Deux particules ont les caps 3,1 et −3,1 : dans quelle direction regardent-elles toutes les deux ?",
    ),
    Trial(
        id="estimer_poids",
        title="Estimer : les particules lourdes comptent plus",
        points=1,
        functions=(ESTIMATE,),
        protocol=estimates.weighed,
        hint="Si une seule particule a tout le poids, où est le robot ? Que répond votre fonction ?",
    ),
    TrialBeside(
        id="forme",
        title="Un pas : un nuage (n, 3), et des poids de somme 1",
        points=1,
        functions=(STEP,),
        protocol=steps.well_formed,
        hint="Que vaut la somme de vos poids juste avant le return ?",
    ),
    Trial(
        id="deplacement",
        title="Un pas : chaque particule avance dans son propre repère",
        points=2,
        functions=(STEP,),
        protocol=steps.moved,
        hint="Une particule regarde vers +y, et u = (1, 0, 0) : vers où avance-t-elle ?",
    ),
    Trial(
        id="dispersion",
        title="Un pas : des particules confondues se dispersent",
        points=1,
        functions=(STEP,),
        protocol=steps.dispersed,
        hint="Combien de nombres tirez-vous au hasard pour déplacer n particules ?",
    ),
    Trial(
        id="pesee",
        title="Un pas : le nuage qui explique le scan l'emporte",
        points=2,
        functions=(STEP,),
        protocol=steps.won,
        hint="Pour deux poses, l'une bonne et l'autre non, que valent vos deux vraisemblances ?",
    ),
    TrialBeside(
        id="memoire",
        title="Deux pas : ni oubli, ni double compte, ni choix sans raison",
        points=2,
        functions=(STEP,),
        protocol=memory.remembered,
        hint="Que deviennent les anciens poids quand vous ne rééchantillonnez pas ? Et quand vous rééchantillonnez ?",
    ),
    Trial(
        id="immobile",
        title="Huit scans à l'arrêt : le bon groupe remplit le nuage",
        points=1,
        functions=(STEP,),
        protocol=steps.filled,
        hint="Combien de particules loin du robot votre nuage garde-t-il, et qui les remplace ?",
    ),
    Untouched(
        id="arguments",
        title="Les tableaux donnés restent intacts",
        points=1,
        functions=(STEP, ESTIMATE),
        names={STEP: ("particules", "poids", "u", "scan"), ESTIMATE: ("particules", "poids")},
        inputs=steps.arguments_to_keep,
        chance=(STEP,),
        hint="Écrivez-vous dans particules ou dans poids, avec += par exemple ?",
    ),
    ClosedLoop(
        id="suivi",
        title="Suivre un robot pendant trente pas",
        points=4,
        functions=(STEP, ESTIMATE),
        runs=runs.RUNS,
        needed=runs.TRACKED,
        kit=runs.kit_of_tracking,
        play=runs.play_tracking,
        after=ONE_STEP,
        hint="À quel pas le nuage perd-il le robot ? Regardez le film : que se passe-t-il juste avant ?",
    ),
    ClosedLoop(
        id="de_nulle_part",
        title="Trouver un robot perdu sur une petite carte",
        points=1,
        functions=(SEED, STEP, ESTIMATE),
        runs=runs.RUNS,
        needed=runs.FOUND,
        kit=runs.kit_from_nowhere,
        play=runs.play_from_nowhere,
        after=("semer", *ONE_STEP),
        hint="Après le premier scan, reste-t-il des particules près du robot ? Votre vraisemblance n'est-elle pas trop "
        "pointue ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES, heavy=True)
