"""Retrieval questions of the séance on localisation: one function a question, whose numbers `rng` draws."""

from __future__ import annotations

import math

import numpy as np

from graders.core.answers.retrieval import RetrievalQuestion, WrongAnswer
from graders.core.compare.words import number


def _pick(rng: np.random.Generator, values: list[float]) -> float:
    return values[int(rng.integers(len(values)))]


def case(rng: np.random.Generator) -> RetrievalQuestion:
    x, y = int(rng.integers(2, 12)), int(rng.integers(12, 20))
    return RetrievalQuestion(
        text=f"Le robot est au point x = {x},7 et y = {y},2. Comment demander si sa case est libre ?",
        answer=f"`libres[{y}, {x}]`",
        why="La ligne vient d’abord, et c’est y ; puis la colonne, x. Chacun est arrondi vers le bas.",
        wrong=(
            WrongAnswer(f"`libres[{x}, {y}]`", "x et y sont échangés : un tableau se lit ligne d’abord."),
            WrongAnswer(
                f"`libres[{y}, {x + 1}]`",
                f"La colonne {x} va de {x} inclus à {x + 1} exclu : on n’arrondit pas au plus près.",
            ),
        ),
    )


def rayon(rng: np.random.Generator) -> RetrievalQuestion:
    theta, n = 10 * int(rng.integers(2, 8)), int(_pick(rng, [12, 36, 72]))
    k = n // 4 if rng.integers(2) else n // 3
    turn = 360 * k // n
    return RetrievalQuestion(
        text=f"Le cap du robot est de {theta}°, et son lidar envoie {n} rayons. Dans quelle direction part le "
        f"rayon {k} ?",
        answer=theta + turn,
        unit="°",
        tolerance=0.5,
        why=f"Le rayon k part à θ + 360° × k/n, soit {theta}° + {turn}°.",
        wrong=(
            WrongAnswer(turn, "Vous avez oublié le cap : les rayons tournent avec le robot."),
            WrongAnswer(theta - turn, "Les rayons se comptent dans le sens positif : on ajoute."),
        ),
    )


def ligne(rng: np.random.Generator) -> RetrievalQuestion:
    column, tenths = int(rng.integers(3, 9)), int(rng.integers(2, 5))
    cosine = 0.8
    distance, back = (10 - tenths) / 10 / cosine, tenths / 10 / cosine
    return RetrievalQuestion(
        text=f"Un rayon part de x = {column},{tenths} vers les x croissants, et le cosinus de sa direction vaut 0,8. "
        "À quelle distance coupe-t-il la prochaine ligne verticale de la grille ?",
        answer=distance,
        unit="case",
        tolerance=0.011,
        why=f"Il reste {number((10 - tenths) / 10)} case en x ; le long du rayon, c’est "
        f"{number((10 - tenths) / 10)} / 0,8.",
        wrong=(
            WrongAnswer(back, "Ce serait la ligne d’où il vient : il s’en éloigne."),
            WrongAnswer(
                (10 - tenths) / 10 * cosine, "On divise par le cosinus : le rayon est plus long que sa projection."
            ),
            WrongAnswer((10 - tenths) / 10, "C’est la distance en x ; le rayon, oblique, parcourt davantage."),
        ),
    )


def pas(rng: np.random.Generator) -> RetrievalQuestion:
    left, track = int(rng.integers(8, 15)), int(_pick(rng, [20, 25, 40, 50]))
    extra = int(rng.integers(2, 6))
    return RetrievalQuestion(
        text=f"En un pas, la roue gauche a parcouru {left} cm, la droite {left + extra} cm ; l’entraxe est de "
        f"{track} cm. "
        "De combien de radians le robot a-t-il tourné ?",
        answer=extra / track,
        unit="rad",
        why=f"Δθ est la différence des chemins, droite moins gauche, divisée par l’entraxe : {extra} / {track}.",
        wrong=(
            WrongAnswer(
                -extra / track, "Le signe est celui de droite moins gauche : la roue droite est allée plus loin."
            ),
            WrongAnswer(
                (2 * left + extra) / 2 / track, "C’est l’avance, moyenne des deux roues, que vous avez divisée."
            ),
            WrongAnswer(2 * extra / track, "On divise par l’entraxe entier, la distance entre les deux roues."),
        ),
    )


def cap(rng: np.random.Generator) -> RetrievalQuestion:
    sigma, root = int(rng.integers(2, 8)), int(_pick(rng, [10, 20, 30]))
    return RetrievalQuestion(
        text=f"À chaque pas, l’erreur de cap a un écart-type de {sigma} millièmes de radian, et les pas sont "
        "indépendants. "
        f"Quel est l’écart-type du cap, en millièmes de radian, après {root * root} pas ?",
        answer=sigma * root,
        why=f"Les variances s’ajoutent : l’écart-type est multiplié par √{root * root} = {root}.",
        wrong=(
            WrongAnswer(
                sigma * root * root, "Vous avez ajouté les écarts-types : ce sont les variances qui s’ajoutent."
            ),
            WrongAnswer(sigma, "L’erreur grandit : chaque pas ajoute la sienne, et rien ne l’efface."),
            WrongAnswer(sigma / root, "C’est une moyenne qui se resserre ainsi ; ici, les erreurs s’additionnent."),
        ),
    )


def porte(rng: np.random.Generator) -> RetrievalQuestion:
    seen, prior = int(_pick(rng, [7, 8, 9])), int(_pick(rng, [2, 3, 4, 6]))
    top, rest = prior * seen, (10 - prior) * (10 - seen)
    return RetrievalQuestion(
        text=f"Le robot croit être devant une porte avec la probabilité 0,{prior}. Son capteur dit « porte » "
        f"{seen} fois sur 10 "
        f"devant une porte, {10 - seen} fois sur 10 ailleurs. Il dit « porte ». Que vaut maintenant la probabilité ?",
        answer=top / (top + rest),
        tolerance=0.011,
        why=f"On multiplie chaque possibilité par sa vraisemblance, puis on divise par la somme : 0,{top:02} / "
        f"(0,{top:02} + 0,{rest:02}).",
        wrong=(
            WrongAnswer(top / 100, "Il manque la division par la somme des deux produits."),
            WrongAnswer(seen / 10, "C’est la vraisemblance seule : ce que l’on croyait avant compte aussi."),
        ),
    )


def glisse(rng: np.random.Generator) -> RetrievalQuestion:
    percent = int(rng.integers(2, 6)) * 10
    reach = percent * 8 / 1000
    return RetrievalQuestion(
        text=f"Une case porte une croyance de {number(percent / 100)}. Le robot tente d’avancer vers l’est : il "
        "y arrive 8 fois "
        "sur 10, sinon il reste. La case à l’est n’avait rien. Combien reçoit-elle ?",
        answer=reach,
        tolerance=0.0011,
        why=f"Prédire répartit : 0,8 × {number(percent / 100)} passe à l’est, le reste ne bouge pas.",
        wrong=(
            WrongAnswer(percent / 100, "Tout ne passe pas : deux fois sur dix, le robot reste où il est."),
            WrongAnswer(percent * 2 / 1000, "C’est la part qui reste sur place."),
            WrongAnswer(0.8, "C’est la probabilité d’avancer ; il faut encore qu’il ait été dans la case."),
        ),
    )


def deux_nuages(rng: np.random.Generator) -> RetrievalQuestion:
    left, right = int(rng.integers(2, 6)), int(rng.integers(14, 20))
    middle = number((left + right) / 2)
    return RetrievalQuestion(
        text=f"La moitié des particules est en x = {left}, l’autre en x = {right}, et les poids sont égaux. "
        f"Que vaut une moyenne annoncée en x = {middle} ?",
        answer="Rien : aucune particule n’est là, et le robot non plus",
        why="La moyenne de deux bosses tombe entre elles. On annonce plutôt la pose du nuage le plus lourd.",
        wrong=(
            WrongAnswer(
                "C’est la meilleure estimation possible",
                "Elle l’est d’une seule bosse ; entre deux, c’est peut-être un mur.",
            ),
            WrongAnswer(
                "Elle deviendra juste avec plus de particules",
                "Plus de particules rendent les deux bosses plus nettes, sans les réunir.",
            ),
        ),
    )


def deux_caps(rng: np.random.Generator) -> RetrievalQuestion:
    above, below = int(rng.integers(2, 9)), int(rng.integers(10, 20))
    mean = 360 - (below - above) / 2
    return RetrievalQuestion(
        text=f"Deux particules de même poids ont pour caps {above}° et {360 - below}°. Quel cap moyen annoncer, "
        "entre 0° et 360° ?",
        answer=mean,
        unit="°",
        tolerance=0.6,
        why=f"{360 - below}° est aussi −{below}° : le milieu est à {number((above - below) / 2)}°, donc "
        f"{number(mean)}°.",
        wrong=(
            WrongAnswer(
                (above + 360 - below) / 2, "C’est la direction opposée : on moyenne les vecteurs, pas les angles."
            ),
            WrongAnswer((below - above) / 2, "Le bon écart, mais du mauvais côté de 0°."),
        ),
    )


def gestes(rng: np.random.Generator) -> RetrievalQuestion:
    scale = int(rng.integers(1, 4))
    turn = 10 * int(rng.integers(6, 12))
    return RetrievalQuestion(
        text=f"L’odométrie lit un déplacement de {4 * scale} en x et {3 * scale} en y, et un cap qui tourne de "
        f"{turn}°. "
        "Le robot tourne d’abord de 36,9° ; de combien tourne-t-il à la fin ?",
        answer=turn - 36.9,
        unit="°",
        tolerance=0.2,
        why=f"Les deux rotations font ensemble le changement de cap : {turn}° − 36,9°.",
        wrong=(
            WrongAnswer(float(turn), "La première rotation en a déjà fait une partie."),
            WrongAnswer(turn + 36.9, "On retranche ce que la première rotation a fait."),
            WrongAnswer(5.0 * scale, "C’est la longueur de l’avance, entre les deux rotations."),
        ),
    )


def produit(rng: np.random.Generator) -> RetrievalQuestion:
    rays = 10 * int(rng.integers(20, 41))
    return RetrievalQuestion(
        text=f"Un scan a {rays} rayons, et chacun est lu avec une probabilité voisine de 0,1. Que donne le "
        f"produit des {rays} facteurs ?",
        answer="Zéro, ou presque : on additionne plutôt les logarithmes",
        why=f"Le produit vaut environ 10 à la puissance −{rays}. Un nombre à virgule de la machine s’arrête "
        "vers 10 à la puissance −308.",
        wrong=(
            WrongAnswer("Environ 0,1", "Un produit de facteurs inférieurs à 1 ne cesse de diminuer."),
            WrongAnswer(f"Environ {rays // 10}", "Ce serait la somme des facteurs."),
        ),
    )


def neff(rng: np.random.Generator) -> RetrievalQuestion:
    heavy, others = int(_pick(rng, [5, 6, 7])), 5
    light = (10 - heavy) / 10 / others
    value = 1 / ((heavy / 10) ** 2 + others * light**2)
    return RetrievalQuestion(
        text=f"Six particules : l’une pèse 0,{heavy}, les cinq autres {number(light)} chacune. Combien vaut le "
        "nombre effectif ?",
        answer=value,
        tolerance=0.03,
        why=f"On somme les carrés des poids, {number(1 / value, 4)}, et on prend l’inverse.",
        wrong=(
            WrongAnswer(1 / value, "C’est la somme des carrés : il reste à prendre l’inverse."),
            WrongAnswer(6.0, "C’est le nombre de particules ; elles ne valent autant qu’à poids égaux."),
        ),
    )


def copies(rng: np.random.Generator) -> RetrievalQuestion:
    count, tenths = 10 * int(rng.integers(5, 12)), int(rng.integers(21, 29))
    expected = tenths / 10
    weight = number(expected / count, 3)
    low = tenths // 10
    return RetrievalQuestion(
        text=f"Le peigne tire {count} copies. Une particule pèse {weight}, soit {number(expected)} copies "
        "attendues. Combien en reçoit-elle ?",
        answer=f"{low} ou {low + 1}",
        why="Les dents sont régulières : entre deux bords, il en tombe la partie entière du nombre attendu, ou "
        "une de plus.",
        wrong=(
            WrongAnswer(
                f"De 0 à {count}", "Ce serait la loterie ; le peigne n’a qu’un seul tirage, et des dents régulières."
            ),
            WrongAnswer(
                f"Toujours {round(expected)}", "Selon le décalage du peigne, il peut en tomber une de plus ou de moins."
            ),
        ),
    )


def lateral(rng: np.random.Generator) -> RetrievalQuestion:
    distance, milli = 10 * int(rng.integers(5, 13)), 10 * int(rng.integers(8, 16))
    worst = distance * milli / 1000
    return RetrievalQuestion(
        text=f"Au bout de {distance} m en ligne droite, l’écart-type du cap est de {number(milli / 1000)} rad, "
        "atteint peu à peu. "
        "Quel est, en mètres, l’écart-type de l’écart latéral ?",
        answer=worst / math.sqrt(3),
        unit="m",
        tolerance=0.02 * worst,
        why=f"D σ / √3 : {number(worst)} m divisés par 1,732.",
        wrong=(
            WrongAnswer(worst, "C’est l’estimation pessimiste, d’un cap faux dès le premier pas."),
            WrongAnswer(worst / 2, "On divise par √3, pas par 2 : ce sont des variances que l’on additionne."),
        ),
    )


def rayons_par_seconde(rng: np.random.Generator) -> RetrievalQuestion:
    particles, rays = 100 * int(rng.integers(2, 9)), int(_pick(rng, [12, 30, 60]))
    total = particles * rays * 10
    return RetrievalQuestion(
        text=f"{particles} particules, {rays} rayons, dix scans par seconde : combien de rayons lancer chaque "
        "seconde ?",
        answer=total,
        why="Chaque particule lance tous les rayons, à chaque scan : les trois nombres se multiplient.",
        wrong=(
            WrongAnswer(particles * rays, "C’est pour un seul scan."),
            WrongAnswer((particles + rays) * 10, "Chaque particule lance tous les rayons : on multiplie."),
        ),
    )
