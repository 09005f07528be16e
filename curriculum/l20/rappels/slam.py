"""Retrieval questions of the séance on SLAM."""

from __future__ import annotations

import math

import numpy as np

from graders.core.answers.retrieval import RetrievalQuestion, WrongAnswer


def enchainer(rng: np.random.Generator) -> RetrievalQuestion:
    x, y, ahead = int(rng.integers(2, 7)), int(rng.integers(2, 7)), int(rng.integers(1, 5))
    return RetrievalQuestion(
        text=f"Le robot est en ({x} ; {y}), cap 90°, les y montant. Il avance de {ahead}, droit devant lui. Où "
        "est-il ?",
        answer=f"({x} ; {y + ahead})",
        why="Le déplacement, donné dans ses axes, est tourné de son cap avant d’être ajouté.",
        wrong=(
            WrongAnswer(f"({x + ahead} ; {y})", "Vous avez ajouté sans tourner : « devant » dépend du cap."),
            WrongAnswer(
                f"({x} ; {y - ahead})",
                "La rotation est dans l’autre sens : un cap de 90° regarde vers les y croissants.",
            ),
        ),
    )


def biais(rng: np.random.Generator) -> RetrievalQuestion:
    factor = int(rng.choice([4, 9, 16, 25]))
    return RetrievalQuestion(
        text=f"Le trajet devient {factor} fois plus long. Par combien l’erreur de cap est-elle multipliée si "
        "elle vient d’un hasard "
        "indépendant à chaque pas ?",
        answer=math.sqrt(factor),
        why="Une somme d’erreurs indépendantes grandit comme la racine du nombre de pas.",
        wrong=(
            WrongAnswer(float(factor), "C’est un biais qui grandit ainsi ; le hasard se compense en partie."),
            WrongAnswer(1.0, "Elle grandit : rien n’efface les erreurs passées."),
        ),
    )


def centres(rng: np.random.Generator) -> RetrievalQuestion:
    shift = int(rng.integers(2, 9))
    return RetrievalQuestion(
        text=f"Deux nuages appariés ont pour centres (0 ; 0) et ({shift} ; 0), et la meilleure rotation est "
        "d’un quart de tour. Que vaut t ?",
        answer=f"({shift} ; 0)",
        why="t est le centre du second, moins la rotation du centre du premier ; celui-ci est à l’origine, et "
        "n’en bouge pas.",
        wrong=(
            WrongAnswer(f"(0 ; {shift})", "La rotation s’applique au premier centre, qui est nul ; pas au second."),
            WrongAnswer(f"(−{shift} ; 0)", "t mène du premier nuage au second : le sens est inversé."),
        ),
    )


def icp_arret(rng: np.random.Generator) -> RetrievalQuestion:
    angle = 10 * int(rng.integers(7, 13))
    return RetrievalQuestion(
        text=f"ICP part d’un angle faux de {angle}°, et son erreur cesse de baisser. Que sait-on ?",
        answer="Il est dans un creux, peut-être pas le bon",
        why="Le théorème dit que l’erreur ne remonte pas, pas où elle s’arrête : il faut un bon départ.",
        wrong=(
            WrongAnswer("Il a trouvé le bon recalage", "Il descend vers le creux le plus proche, comme une bille."),
            WrongAnswer("Il faut l’arrêter plus tard", "L’erreur ne baisse plus : d’autres tours ne changeront rien."),
        ),
    )


def information(rng: np.random.Generator) -> RetrievalQuestion:
    factor = int(rng.integers(2, 6))
    return RetrievalQuestion(
        text=f"Une mesure a un écart-type {factor} fois plus petit qu’une autre. Par combien son information "
        "est-elle multipliée ?",
        answer=float(factor * factor),
        why="L’information est l’inverse de la variance, qui est le carré de l’écart-type.",
        wrong=(
            WrongAnswer(float(factor), "Ce serait l’inverse de l’écart-type : il manque le carré."),
            WrongAnswer(1 / factor**2, "Plus précise, elle tire plus fort : l’information grandit."),
        ),
    )


def noyau(rng: np.random.Generator) -> RetrievalQuestion:
    poses = int(rng.integers(20, 90))
    return RetrievalQuestion(
        text=f"Un graphe connexe de {poses} poses du plan, sans pose fixée : quelle est la dimension du noyau de H ?",
        answer=3.0,
        tolerance=0.1,
        why="Deux translations et une rotation d’ensemble ne changent aucune mesure relative.",
        wrong=(
            WrongAnswer(0.0, "Déplacer tout le graphe ne change aucune erreur : H ne peut être inversible."),
            WrongAnswer(2.0, "Il y a aussi la rotation d’ensemble."),
            WrongAnswer(float(3 * poses), "C’est le nombre d’inconnues."),
        ),
    )


def blocs(rng: np.random.Generator) -> RetrievalQuestion:
    first = int(rng.integers(2, 20))
    second = first + int(rng.integers(5, 30))
    return RetrievalQuestion(
        text=f"Une arête relie les poses {first} et {second}. Combien de blocs 3 × 3 de H touche-t-elle ?",
        answer=4.0,
        tolerance=0.1,
        why=f"Deux sur la diagonale, et les deux blocs symétriques qui relient {first} et {second}.",
        wrong=(
            WrongAnswer(2.0, "Chaque pose a aussi un bloc en commun avec l’autre, de chaque côté de la diagonale."),
            WrongAnswer(1.0, "La mesure dépend des deux poses : leurs propres blocs changent aussi."),
        ),
    )


def chaine(rng: np.random.Generator) -> RetrievalQuestion:
    poses = int(rng.integers(30, 90))
    return RetrievalQuestion(
        text=f"{poses} poses, l’odométrie seule, aucune fermeture. Que change l’optimisation ?",
        answer="Rien : tous les ressorts sont déjà au repos",
        why="Sans retour, aucune mesure n’en contredit une autre : le trajet de l’odométrie a une erreur nulle.",
        wrong=(
            WrongAnswer("Elle réduit la dérive de moitié", "Rien ne dit de combien on a dérivé : il faut un retour."),
            WrongAnswer(
                "Elle redresse le dernier tiers du trajet",
                "Seule une mesure qui contredit les autres redresse quelque chose.",
            ),
        ),
    )


def crans(rng: np.random.Generator) -> RetrievalQuestion:
    rays = int(rng.choice([36, 72, 90]))
    turn = 360 // rays
    return RetrievalQuestion(
        text=f"Un scan a {rays} rayons. De quels angles un robot peut-il tourner sans rien changer au module de "
        "sa transformée de Fourier ?",
        answer=f"Les multiples de {turn}°",
        why="Tourner d’un cran décale la liste des rayons : seule la phase change. Entre deux crans, les rayons "
        "tombent ailleurs.",
        wrong=(
            WrongAnswer(
                "Tous", "Entre deux crans, les rayons touchent d’autres points : l’invariance n’est qu’approchée."
            ),
            WrongAnswer("Aucun, sauf un tour entier", "Un décalage circulaire ne change que la phase."),
        ),
    )
