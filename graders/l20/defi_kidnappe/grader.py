"""l20/defi_kidnappe (★): a localisation that finds a robot again which somebody has carried away.

Measured on the honest filters of `specimens/ok`, run by run, and without injection: filters guided by the scan find the
robot 99 % of the time and more; 10 % sown anywhere, 93 to 98 %; 5 % sown anywhere, 84 to 93 %; none, 12 %; all injected
at one place, 27 % (3 to 5 runs of the fifteen, on eight seeds). Seven runs of fifteen are needed. At 84 % an honest
filter is refused 14 times in 100,000 (eight runs would refuse it once in 1,000); at 12 % one that sows nothing would
pass once in 1,000, did it not fail `injection` for sure. A window of 20 steps, or of 40, changes these chances by three
points at most: what a filter finds again it keeps.
"""

from __future__ import annotations

from graders.core.code.checks import Trial, Untouched
from graders.core.code.exercise import code
from graders.core.code.loops import ClosedLoop
from graders.l20 import world
from graders.l20.defi_kidnappe import estimates, runs, trials
from graders.l20.defi_kidnappe.probes import PROBES
from graders.l20.mcl import sowing, steps
from graders.l20.mcl.answers import ESTIMATE, SEED, STEP
from graders.l20.mcl.contract import contracts
from graders.l20.mcl.estimates import averaged
from graders.l20.mcl.grader import TrialBeside

CHECKS = (
    Trial(
        id="semer",
        title="Semer : partout sur les cases libres, avec tous les caps",
        points=1,
        functions=(SEED,),
        protocol=sowing.sown,
        hint="C'est la fonction de l'exercice sur la localisation de Monte-Carlo : l'avez-vous reprise telle quelle ?",
    ),
    Trial(
        id="estimer_milieu",
        title="Estimer : le milieu du nuage, même autour de ±π",
        points=1,
        functions=(ESTIMATE,),
        protocol=averaged,
        hint="Deux particules ont les caps 3,1 et −3,1 : dans quelle direction regardent-elles toutes les deux ?",
    ),
    Trial(
        id="estimer_poids",
        title="Estimer : là où est le poids, pas là où est le nombre",
        points=1,
        functions=(ESTIMATE,),
        protocol=estimates.weighed,
        hint="Dix particules ont presque tout le poids, cent n'en ont presque pas : où est le robot ?",
    ),
    TrialBeside(
        id="forme",
        title="Un pas : un nuage (n, 3), et des poids de somme 1",
        points=1,
        functions=(STEP,),
        protocol=trials.well_formed,
        hint="Après l'injection, que vaut la somme de vos poids ?",
    ),
    Trial(
        id="deplacement",
        title="Un pas : le gros du nuage suit les roues",
        points=1,
        functions=(STEP,),
        protocol=steps.moved,
        hint="Combien de particules gardez-vous quand tout va bien ?",
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
        hint="Quel poids donnez-vous aux particules injectées, à côté de celles qui expliquent le scan ?",
    ),
    TrialBeside(
        id="perdu",
        title="Un nuage perdu a encore des poids",
        points=2,
        functions=(STEP,),
        protocol=trials.survives_being_lost,
        hint="Quand aucune particule n'explique le scan, que vaut la somme de vos vraisemblances ?",
    ),
    Trial(
        id="injection",
        title="Après un enlèvement, des particules apparaissent ailleurs",
        points=2,
        functions=(STEP,),
        protocol=trials.looks_elsewhere,
        hint="Toutes vos particules descendent-elles de celles d'avant ? Comment une autre pose pourrait-elle gagner ?",
    ),
    Untouched(
        id="arguments",
        title="Les tableaux donnés restent intacts",
        points=1,
        functions=(STEP, ESTIMATE),
        names={STEP: ("particules", "poids", "u", "scan"), ESTIMATE: ("particules", "poids")},
        inputs=steps.arguments_to_keep,
        chance=(STEP,),
        hint="Écrivez-vous les particules injectées dans le tableau reçu ?",
    ),
    ClosedLoop(
        id="enlevement",
        title="Retrouver un robot enlevé",
        points=7,
        functions=(SEED, STEP, ESTIMATE),
        runs=runs.RUNS,
        needed=runs.FOUND,
        kit=runs.kit,
        play=runs.play,
        after=("semer", "forme", "deplacement", "dispersion", "pesee", "perdu", "injection"),
        seconds=400.0,
        hint="Au hasard, une pose injectée a peu de chances d'être la bonne. Le scan peut-il aider à choisir ?",
    ),
)

RELAUNCHED = (
    "est lancé une fois pour les premières vérifications, où les appels se suivent ; puis une fois pour chaque essai, "
    "sur une autre carte."
)

DEFINITION = code(__file__, checks=CHECKS, contracts=contracts(RELAUNCHED), kit=world.kit, probes=PROBES, heavy=True)
