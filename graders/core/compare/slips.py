"""The usual slips, whatever the exercise: recognised by comparing what came back with what was expected."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graders.core.contract.values import Floats


@dataclass(frozen=True)
class Slip:
    """A slip by name, said to the student in French; `question` makes them see it; `alone` is as in `Misconception`."""

    id: str
    title: str
    explanation: str
    question: str
    alone: tuple[str, ...] = ()


SLIPS = {
    slip.id: slip
    for slip in (
        Slip(
            "forme",
            "Un résultat de la mauvaise forme",
            "Les valeurs ne sont pas rangées dans un tableau de la forme demandée.",
            "Que vaut np.shape(...) pour votre résultat, et que demande l'énoncé ?",
        ),
        Slip(
            "transposee",
            "Un tableau transposé",
            "Vos valeurs sont les bonnes, mais lignes et colonnes sont échangées.",
            "Dans un tableau (H, W), le premier indice désigne-t-il x ou y ?",
            ("Vos valeurs sont les bonnes, mais lignes et colonnes sont échangées.",),
        ),
        Slip(
            "nan",
            "Un résultat qui n'est pas un nombre (NaN)",
            "Votre calcul produit « nan » : une division 0/0, la racine ou le logarithme d'un nombre négatif.",
            "Quelle division de votre code peut avoir un dénominateur nul ?",
        ),
        Slip(
            "degres",
            "Des degrés au lieu de radians",
            "L'angle renvoyé est exprimé en degrés : le module ne compte qu'en radians.",
            "Un quart de tour vaut-il 90 ou π/2 dans ce module ?",
        ),
        Slip(
            "radians_doubles",
            "Des radians convertis une fois de trop",
            "L'angle reçu est déjà en radians ; votre code le convertit encore.",
            "L'angle donné vaut-il déjà π/2 pour un quart de tour ?",
        ),
        Slip(
            "oppose",
            "Le signe opposé",
            "Votre résultat est exactement l'opposé de celui qui est attendu.",
            "Dans quel sens faites-vous la soustraction ?",
            ("Votre résultat est exactement l'opposé de celui qui est attendu.",),
        ),
        Slip(
            "non_normalise",
            "Des probabilités qui ne somment pas à 1",
            "Vos valeurs sont proportionnelles aux bonnes, mais leur somme n'est pas 1.",
            "Que devient la constante η de la formule de Bayes dans votre code ?",
            ("Vos valeurs sont proportionnelles aux bonnes, mais leur somme n'est pas 1.",),
        ),
        Slip(
            "angle_non_ramene",
            "Un angle qui n'est pas ramené dans ]−π, π]",
            "L'angle est juste à un nombre entier de tours près. Il sort de l'intervalle ]−π, π], où il est à ramener "
            "une fois calculé.",
            "Que devient votre angle quand il dépasse un demi-tour ?",
            ("L'angle est juste à un nombre entier de tours près.",),
        ),
        Slip(
            "argument_modifie",
            "Un argument modifié sur place",
            "Votre fonction change le tableau qu'on lui a donné : celui qui l'appelle perd ses données.",
            "Faut-il écrire dans le tableau reçu, ou dans une copie ?",
        ),
        Slip(
            "indices_au_lieu_de_copies",
            "Des indices au lieu des particules",
            "Votre fonction renvoie les numéros des particules choisies, pas les particules elles-mêmes.",
            "Que contient particules[indices] ?",
        ),
        Slip(
            "memoire",
            "Un résultat qui dépend des appels précédents",
            "Avec les mêmes arguments, votre fonction ne renvoie pas deux fois la même chose : elle garde quelque "
            "chose d'un appel à l'autre, dans une variable globale, un tableau réutilisé ou un argument par défaut.",
            "Quelle variable de votre code existe encore quand la fonction est finie ?",
        ),
        Slip(
            "resultat_partage",
            "Un résultat que l'appel suivant change",
            "Votre fonction renvoie à chaque appel le même tableau, qu'elle réécrit : celui qui garde un résultat "
            "le voit changer à l'appel d'après.",
            "Où est créé le tableau que vous renvoyez : dans la fonction, ou une fois pour toutes ?",
        ),
        Slip(
            "hasard",
            "Un résultat tiré au hasard",
            "Avec les mêmes arguments, votre fonction ne renvoie pas deux fois la même chose, et le même fichier "
            "relancé donne encore autre chose : il y entre un nombre aléatoire. Ici le résultat ne dépend que des "
            "arguments.",
            "Quelle ligne de votre code tire un nombre au hasard, ou ajoute un bruit ?",
        ),
        Slip(
            "entiers",
            "Des nombres tronqués à des entiers",
            "Vos valeurs sont les bonnes, mais sans leur partie décimale : un tableau créé avec des entiers, comme "
            "np.array([0, 0, 0]), ne garde que des entiers.",
            "Quel est le dtype du tableau où vous rangez vos résultats ?",
            ("Vos valeurs sont les bonnes, mais sans leur partie décimale : ",),
        ),
        Slip(
            "arrondi",
            "Un résultat arrondi",
            "Vos valeurs sont les bonnes à quelques décimales près : un arrondi (np.round, float32) leur fait perdre "
            "leur précision.",
            "Pourquoi arrondir avant d'avoir fini le calcul ?",
            (
                "Vos valeurs sont les bonnes à quelques décimales près : un arrondi (np.round, float32) leur fait "
                "perdre leur précision.",
            ),
        ),
        Slip(
            "simple_precision",
            "Un calcul en simple précision",
            "Vos valeurs sont les bonnes à sept chiffres près, ou moins : c'est ce que garde un nombre sur 32 bits "
            "(float32). Sans rien demander, numpy calcule sur 64 bits et en garde seize.",
            "Quel type demandez-vous à vos tableaux, et pourquoi ?",
        ),
        Slip(
            "precision_perdue",
            "Des résultats justes à quelques chiffres près seulement",
            "Vos valeurs approchent les bonnes sans les atteindre. Cela vient souvent d'un arrondi, d'une constante "
            "écrite avec trop peu de chiffres, d'un terme ajouté « pour ne pas diviser par zéro », d'une valeur "
            "bornée, d'un calcul en float32, ou d'un calcul approché dont le pas est trop grand.",
            "Quelle ligne de votre code ne calcule qu'à peu près ?",
        ),
        Slip(
            "constante_arrondie",
            "Une constante écrite avec trop peu de chiffres",
            "π a une infinité de chiffres ; en écrire quelques-uns fausse tous les calculs à partir du suivant, et "
            "numpy en donne autant que la machine en garde.",
            "À combien de chiffres près votre résultat est-il juste ?",
        ),
        Slip(
            "virgule_decimale",
            "Une virgule décimale dans un nombre",
            "En Python, la virgule sépare deux valeurs : « 0,5 » en fait deux, 0 et 5. Le séparateur décimal est le "
            "point.",
            "Combien de valeurs votre fonction renvoie-t-elle ?",
        ),
        Slip(
            "sans_retour",
            "La fonction ne renvoie rien",
            "Une fonction sans « return », ou dont le « return » n'est pas atteint, renvoie None. Afficher un résultat "
            "avec print n'est pas le renvoyer.",
            "Que reçoit celui qui appelle votre fonction ?",
        ),
        Slip(
            "scalaire",
            "Un seul nombre au lieu d'un tableau",
            "Votre fonction réduit tout à un seul nombre là où il en faut plusieurs.",
            "Une somme ou une moyenne s'applique-t-elle ici à tout le tableau ?",
        ),
    )
}


def shape_slip(expected: Floats, got: Floats) -> str:
    """Name the slip behind a wrong shape."""
    if got.ndim == 2 and got.shape == expected.shape[::-1] and np.allclose(got.T, expected):
        return "transposee"
    return "scalaire" if got.ndim == 0 else "forme"


def value_slip(expected: Floats, got: Floats) -> str | None:
    """Name the slip behind wrong values in the right shape, when one explains them all."""
    if np.any(np.isnan(got)):
        return "nan"
    if not np.any(expected) or not np.all(np.isfinite(got)):
        return None
    if got.ndim == 2 and got.shape[0] == got.shape[1] and np.allclose(got.T, expected):
        return "transposee"
    if np.allclose(got, -expected):
        return "oppose"
    return "degres" if got.ndim == 0 and np.allclose(got, np.degrees(expected)) else None
