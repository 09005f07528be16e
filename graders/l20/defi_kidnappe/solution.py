from mes_fonctions import estimer, initialiser
from mes_fonctions import pas_mcl as un_pas


def pas_mcl(particules, poids, u, scan):
    """Le pas de la MCL, puis l'injection : une pose que personne n'occupe ne gagnerait jamais."""
    particules, poids = un_pas(particules, poids, u, scan)
    # Une particule sur dix est semée de nouveau, n'importe où. Leurs places sont tirées au hasard : les dernières
    # seraient toujours les copies des mêmes particules.
    semees = rng.choice(len(particules), len(particules) // 10)
    particules[semees] = initialiser(len(semees))
    # Elles gardent leur poids : si l'une explique le prochain scan, ses copies prendront la place des autres.
    return particules, poids
