"""l20/boucles: recognising a place by a signature that ignores the heading (course exercise 4).

Any descriptor and any norm may be chosen, so nothing is compared with a reference. `signature` is asked to be the same
when the scan is shifted and not to be constant. `candidats_boucle` is asked, with a threshold beyond any distance, for
exactly the scans of its window; then, on walks, for a threshold that separates the visits of one place from the other
places. That threshold is found by bisection on the student's own answers (`calibration`): what is found grows with the
threshold in every norm, so that the search is exact and a scale is never assumed. One threshold must serve all the
queries of one walk, no more. The window being judged apart, walks judge only the scans j <= i - 10, and hold no match
at i - 10 itself: one mistake costs its own check.

Why the mark does not depend on the seed. Each check begins with walks that never change; the other map never does
either. Walks of this grading come after, which no program has seen: of one that the look-alikes catch anyway, they
show no more than their draw, so that this is left to `sosies`.

Why no honest submission is rejected. Walks are made of places that 31 usual descriptors (`family`: amplitudes and
powers of Fourier, autocorrelations, sorted distances, histograms with fixed or adaptive boxes, two statistics or more,
the scan turned to its longest or shortest ray) separate in each of 4 distances, with all the noise of the walk and a
factor 2 in hand; a walk that does not is drawn again. Shifted scans are exact copies, no ray is at the end of the
range, the longest and the shortest ray are unique: ties have a scan of their own, made by hand, where a signature that
starts from one ray always fails, and no walk fails it by chance. Equal distances within one scan, which have another
scan by hand, come with the noisy walk that never changes, read to the hundredth: what forgets how many they are has
another length at each reading. Within the family, but for these two, a rejection is
thus impossible by construction. A choice outside it may meet a walk whose places it confuses: it is then given two
other walks; the walks that never change are passed by all the choices measured below. What was found is asked again
with the same scans in another order, which a function that remembers fails.

Measured on the 49 descriptors and 9 distances of `tests/graders/boucles_styles.py`, many outside the family. With one
walk and 29 descriptors, 2 gradings of 20 244 were rejected, in the noisy walk (a bare logarithm of the spectrum by its
largest gap; area and perimeter by their cosine). These two descriptors joined the family and the spare walks came:
8 676 gradings on 180 new seeds, none rejected. At 1e-4 a walk, three independent walks make a rate of 1e-12; for a
fragile choice that confuses one walk in a hundred, as those two may have done, 1e-6.

Why one number is not enough. In a trap, two places have the same mean (standard deviation, longest ray), and the noise
is such that by this number the other place is nearer than the same place: no threshold can separate. The look-alikes
are such places for many numbers, and for the norms, sums and largest signed differences that a poor comparison makes
of a good signature. A signature of length 1 is also put to a trap made for its own values.
"""

from __future__ import annotations

import numpy as np

from graders.core.code.checks import Trial, Untouched
from graders.core.code.exercise import code
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.boucles import searches, trials
from graders.l20.boucles.contract import CONTRACTS
from graders.l20.boucles.places import BEAMS
from graders.l20.boucles.probes import PROBES

SIGNATURE = ("signature",)
CANDIDATES = ("candidats_boucle",)
BOTH = SIGNATURE + CANDIDATES


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    scans = rng.uniform(1.0, 9.0, (13, BEAMS))
    return {"signature": (scans[0],), "candidats_boucle": (scans, 12, 1.0)}


CHECKS = (
    Trial(
        id="signature_exemple",
        title="Signature : les mêmes distances décalées d'un rayon",
        points=2,
        functions=SIGNATURE,
        protocol=trials.example,
        hint="Votre résultat dépend-il de l'ordre dans lequel les 36 distances sont rangées ?",
    ),
    Trial(
        id="signature_rotation",
        title="Signature : le robot tourne sur place",
        points=3,
        functions=SIGNATURE,
        protocol=trials.rotation,
        hint="Tourner de 10° décale le scan d'un cran : quelles quantités calculées sur le scan restent les mêmes ?",
    ),
    Trial(
        id="fenetre",
        title="Candidats : tous les j ≤ i − 10, et eux seuls",
        points=3,
        functions=CANDIDATES,
        protocol=trials.window,
        hint="Avec i = 10, quel est le seul candidat possible ? Et avec i = 9 ?",
    ),
    Trial(
        id="lieux",
        title="Même endroit trouvé, autres endroits non",
        points=3,
        functions=BOTH,
        protocol=searches.places,
        hint="Quelle distance sépare les signatures de deux scans du même endroit ? Et de deux endroits différents ?",
    ),
    Trial(
        id="autre_carte",
        title="Sur une autre carte",
        points=1,
        functions=BOTH,
        protocol=searches.other_places,
        hint="Votre code emploie-t-il des nombres qui ne valent que pour la carte du module ?",
    ),
    Trial(
        id="bruit",
        title="Avec des scans bruités",
        points=3,
        functions=BOTH,
        protocol=searches.noisy_places,
        hint="Deux scans bruités du même endroit ne sont jamais égaux : comparez-vous une distance au seuil ?",
    ),
    Trial(
        id="sosies",
        title="Des endroits qui se ressemblent",
        points=4,
        functions=BOTH,
        protocol=searches.traps,
        hint="Votre signature contient-elle assez de nombres pour décrire un lieu ?",
    ),
    Untouched(
        id="arguments",
        title="Les scans donnés restent intacts",
        points=1,
        functions=BOTH,
        names={"signature": ("scan",), "candidats_boucle": ("scans", "i", "seuil")},
        inputs=arguments_to_keep,
        hint="scan.sort() trie le tableau reçu ; que fait np.sort(scan) ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
