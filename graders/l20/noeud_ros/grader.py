"""l20/noeud_ros: a node of ROS 2 that stops the robot when something is too near.

The class is not compared with a reference: the kit makes it live in a simulated world (`curriculum/l20/kit/ros`), and
what it publishes is judged. Nothing is drawn that an honest node could miss: a phase is six scans in 0.6 s, after
0.4 s during which the lidar sees nothing. Where the robot must be stopped, one zero Twist in these 0.6 s is enough;
where it must not, the node is silent in the last 0.3 s of them, and publishes no speed ever. So are accepted: a node
that publishes at each scan, at the first one, or from a timer of 0.5 s or less; a parameter that is read at each scan,
when it changes, or from such a timer; a node that refuses old scans, or that stops when none has come for a while.

Not judged, as the contract says: −inf, 0, negative readings and those up to range_min; windows mostly unread (a node
that stops when it is blind is a prudent one); obstacles within two beams of an end of the window; scans of fewer than
24 beams. No range is within a millimetre of a bound. A latched stop, which must be released by hand, is refused: the
statement says that nothing is published once the way is free.

What never changes comes first in each check, and does not depend on the seed; the drawn scenes only add. There is no
chance in it: an honest node fails with probability 0, a known mistake passes with probability 0.
"""

from __future__ import annotations

from graders.core.code.exercise import code
from graders.l20.noeud_ros import cases
from graders.l20.noeud_ros.checks import Scenes
from graders.l20.noeud_ros.contract import CONTRACTS
from graders.l20.noeud_ros.probes import PROBES
from graders.l20.noeud_ros.scenes import NODE, kit

FUNCTIONS = (NODE,)

CHECKS = (
    Scenes(
        id="exemples",
        title="Un obstacle devant : plus près que le seuil, ou plus loin",
        points=4,
        functions=FUNCTIONS,
        scenes=cases.examples,
        hint="Votre fonction est-elle appelée à chaque scan ? Affichez-y la plus petite distance qu'elle retient.",
    ),
    Scenes(
        id="fenetre",
        title="Les 20 rayons du milieu, quel que soit le nombre de rayons",
        points=4,
        functions=FUNCTIONS,
        scenes=cases.windows,
        hint="Quels indices votre code regarde-t-il si le scan a 36 rayons ? Et s'il en a 181 ?",
    ),
    Scenes(
        id="lectures",
        title="Les lectures qui ne sont pas des distances",
        points=4,
        functions=FUNCTIONS,
        scenes=cases.readings,
        hint="Que vaut min([nan, 0.2]) ? Et nan < 0.3 ? Que veut dire une lecture plus grande que range_max ?",
    ),
    Scenes(
        id="reglage",
        title="Le paramètre distance_min change en marche",
        points=4,
        functions=FUNCTIONS,
        scenes=cases.settings,
        hint="À quel moment votre nœud lit-il son paramètre : une fois, ou à chaque scan ?",
    ),
    Scenes(
        id="lidars",
        title="Des lidars qui commencent ailleurs",
        points=2,
        functions=FUNCTIONS,
        scenes=cases.lidars,
        hint="L'énoncé parle-t-il du milieu de la liste, ou de l'angle 0 ?",
    ),
    Scenes(
        id="approche",
        title="Le robot s'approche d'un mur, puis s'en éloigne",
        points=2,
        functions=FUNCTIONS,
        scenes=cases.approaches,
        apart=True,
        hint="Quand la voie est libre de nouveau, votre nœud se tait-il ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=kit, probes=PROBES)
