"""l20/tp_slam: part A of the practical work as one chain, from what the wheels count to the map (course, TP).

The journeys are the same for everyone, and nothing is drawn: the same code gets the same marks, and an honest program
that passes once always does. Thresholds stand where they were measured, in `stages`, `maps` and `real`.
"""

from __future__ import annotations

from graders.core.code.checks import Trial
from graders.core.code.exercise import code
from graders.l20 import world
from graders.l20.tp_slam import places, small
from graders.l20.tp_slam.contract import CONTRACTS
from graders.l20.tp_slam.maps import mapping
from graders.l20.tp_slam.probes import PROBES
from graders.l20.tp_slam.real import through_the_laboratory
from graders.l20.tp_slam.stages import closing, key_poses, matching, odometry, show_solved, solving

CHECKS = (
    Trial(
        id="odometrie",
        title="A2. L'odométrie : la trajectoire que comptent les roues",
        points=2,
        functions=("trajectoire",),
        protocol=odometry,
        hint="Combien de poses font n − 1 déplacements ? Quelle est la première ?",
    ),
    Trial(
        id="poses_cles",
        title="A3. Les poses clés",
        points=2,
        functions=("poses_cles",),
        protocol=small.then(small.keys, key_poses),
        hint="Depuis quelle pose compte-t-on les 30 cm ? Que change un cap qui passe de 179° à −179° ?",
    ),
    Trial(
        id="recalages",
        title="A4. Chaque scan clé sur le précédent",
        points=4,
        functions=("recaler",),
        protocol=small.then(small.matches, matching),
        hint="Où sont les points de b, vus de a, avant tout recalage ? Que fait chaque tour à la pose déjà trouvée ?",
    ),
    Trial(
        id="fermetures",
        title="A5. Reconnaître les lieux déjà vus, sans se tromper une seule fois",
        points=4,
        functions=("fermetures",),
        protocol=small.then(places.loops, closing),
        hint="Qu'est-ce qui distingue une paire qui se ressemble d'une paire que le recalage confirme ?",
    ),
    Trial(
        id="graphe",
        title="A6. Le graphe : recalages, odométrie et boucles d'accord",
        points=3,
        functions=("optimiser",),
        protocol=small.then(small.graphs, solving, shown=show_solved),
        hint="Quelle arête croit-on le plus : celle d'écart-type 2 cm, ou celle de 3 cm ? Que vaut Ω pour chacune ?",
    ),
    Trial(
        id="carte",
        title="A7. La carte",
        points=2,
        functions=("carte",),
        protocol=small.then(small.maps, mapping),
        hint="Dans quelle unité `integrer_scan` lit-elle la pose, le scan et la portée ? Où est la case (0, 0) ?",
    ),
    Trial(
        id="intel",
        title="Et en vrai : cent vingt scans du laboratoire d'Intel",
        points=3,
        functions=("recaler", "optimiser"),
        protocol=through_the_laboratory,
        hint="Votre recalage suppose-t-il quelque part 180 rayons, un tour complet ou une portée de 8 m ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES, long=True)
