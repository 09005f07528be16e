"""Retrieval questions of the séance on mapping."""

from __future__ import annotations

import math

import numpy as np

from graders.core.answers.retrieval import RetrievalQuestion, WrongAnswer
from graders.core.compare.words import number


def cote(rng: np.random.Generator) -> RetrievalQuestion:
    against = int(rng.choice([3, 4, 9, 19]))
    return RetrievalQuestion(
        text=f"Une case a la cote {against} : {against} contre 1 qu’elle soit occupée. Quelle est sa probabilité ?",
        answer=against / (against + 1),
        tolerance=0.006,
        why=f"p = o / (1 + o), soit {against} / {against + 1}.",
        wrong=(
            WrongAnswer(1 / against, "C’est l’inverse de la cote ; la probabilité est une part du tout."),
            WrongAnswer(1 / (against + 1), "C’est la probabilité que la case soit libre."),
        ),
    )


def signe(rng: np.random.Generator) -> RetrievalQuestion:
    hundredths = int(rng.integers(10, 25))
    shown = number(hundredths / 10)
    return RetrievalQuestion(
        text=f"Une case a le log-odds {shown}. On échange « occupée » et « libre » : que devient-il ?",
        answer=f"−{shown}",
        why="p devient 1 − p, la cote devient son inverse, et son logarithme change de signe.",
        wrong=(
            WrongAnswer(number(1 - hundredths / 10), "C’est la probabilité qui devient 1 − p, pas son log-odds."),
            WrongAnswer(
                number(10 / hundredths, 2), "C’est la cote qui devient son inverse ; le logarithme, son opposé."
            ),
        ),
    )


def touches(rng: np.random.Generator) -> RetrievalQuestion:
    hits, through = int(rng.integers(3, 7)), int(rng.integers(1, 3))
    value = 0.847 * (hits - through)
    return RetrievalQuestion(
        text=f"Une case jamais vue reçoit {hits} « touchés » à +0,847 et {through} « "
        f"traversé{'s' if through > 1 else ''} » à "
        "−0,847, sans atteindre de borne. Que vaut son log-odds ?",
        answer=value,
        tolerance=0.011,
        why=f"Tout s’additionne à partir de 0 : il reste {hits - through} fois 0,847.",
        wrong=(
            WrongAnswer(0.847 * hits, "Les « traversés » retirent autant que les « touchés » ajoutent."),
            WrongAnswer(
                0.847 * (hits + through), "Un « traversé » vote pour que la case soit libre : il se retranche."
            ),
            WrongAnswer(1 / (1 + math.exp(-value)), "C’est déjà la probabilité ; on demande le log-odds."),
        ),
    )


def arret(rng: np.random.Generator) -> RetrievalQuestion:
    cell, reach = int(rng.integers(4, 9)), int(rng.choice([10, 12, 15]))
    return RetrievalQuestion(
        text=f"La portée est de {reach} cases. Un rayon lit {reach} : il a traversé {cell} cases. Que reçoit la "
        "dernière ?",
        answer="Elle est libre, comme les autres",
        why="Un rayon qui lit la portée n’a rien touché : il n’y a pas de case d’arrêt.",
        wrong=(
            WrongAnswer(
                "Elle est occupée : le rayon s’y arrête",
                "Le rayon ne s’est pas arrêté ; c’est le capteur qui ne voit pas plus loin.",
            ),
            WrongAnswer("Rien : on ne sait rien d’elle", "Le rayon l’a traversée : elle reçoit un vote « libre »."),
        ),
    )


def borne(rng: np.random.Generator) -> RetrievalQuestion:
    limit = int(rng.integers(3, 9))
    return RetrievalQuestion(
        text=f"Une case est saturée à +{limit}. Chaque passage retire 0,847. Après combien de passages son "
        "log-odds devient-il négatif ?",
        answer=float(math.floor(limit / 0.847) + 1),
        tolerance=0.4,
        why=f"Il faut dépasser {limit} / 0,847, soit {number(limit / 0.847, 3)} passages.",
        wrong=(
            WrongAnswer(
                float(math.floor(limit / 0.847)), f"Il en manque un : {limit} / 0,847 n’est pas encore dépassé."
            ),
            WrongAnswer(float(math.ceil(2 * limit / 0.847)), "C’est ce qu’il faut d’une saturation à l’autre."),
        ),
    )


def independance(rng: np.random.Generator) -> RetrievalQuestion:
    scans = 10 * int(rng.integers(5, 20))
    return RetrievalQuestion(
        text=f"Un robot à l’arrêt reçoit {scans} fois le même scan, où une vitre dévie un rayon. Que devient la "
        "case désignée à tort ?",
        answer="La carte en devient sûre, à tort",
        why="L’addition suppose des mesures indépendantes : le même témoin, entendu souvent, est compté comme "
        "une foule.",
        wrong=(
            WrongAnswer("L’erreur se moyenne et disparaît", "Elle est la même à chaque fois : rien ne la compense."),
            WrongAnswer(
                "Rien : un scan répété ne compte qu’une fois",
                "Ce serait sage, mais il faut le programmer : l’addition, elle, compte tout.",
            ),
        ),
    )
