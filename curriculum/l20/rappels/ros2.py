"""Retrieval questions of the séance on ROS 2."""

from __future__ import annotations

import numpy as np

from graders.core.answers.retrieval import RetrievalQuestion, WrongAnswer
from graders.core.compare.words import number


def quel_moyen(rng: np.random.Generator) -> RetrievalQuestion:
    seconds = 10 * int(rng.integers(3, 9))
    return RetrievalQuestion(
        text=f"Faire le tour de l’atelier dure {seconds} s, peut échouer, et doit pouvoir s’interrompre. Quel "
        "moyen de ROS 2 ?",
        answer="Une action",
        why="Un but, des nouvelles en route, un résultat, et l’annulation : c’est la forme d’une action.",
        wrong=(
            WrongAnswer("Un service", f"L’appelant resterait suspendu {seconds} s, sans nouvelles."),
            WrongAnswer("Un topic", "Un flux ne rend pas de résultat, et ne s’annule pas."),
            WrongAnswer("Un paramètre", "C’est un réglage, pas une tâche."),
        ),
    )


def rencontre(rng: np.random.Generator) -> RetrievalQuestion:
    rate = int(rng.choice([5, 10, 20]))
    return RetrievalQuestion(
        text=f"Un lidar publie {rate} scans par seconde « au mieux ». Un nœud s’abonne en demandant « fiable ». "
        "Combien en reçoit-il par seconde ?",
        answer=0.0,
        tolerance=0.1,
        why="L’émetteur doit offrir au moins ce que le lecteur demande : ils ne communiquent pas.",
        wrong=(
            WrongAnswer(
                float(rate), "La demande dépasse l’offre : la rencontre n’a pas lieu, sans erreur dans le code."
            ),
            WrongAnswer(rate / 2, "Rien n’est partagé ni perdu : aucun message ne passe."),
        ),
    )


def freinage(rng: np.random.Generator) -> RetrievalQuestion:
    speed, brake = int(rng.choice([1, 2])), int(rng.choice([1, 2]))
    stop, react = speed * speed / (2 * brake), 0.2 * speed
    return RetrievalQuestion(
        text=f"À {speed} m/s, avec 0,2 s de réaction et un freinage de {brake} m/s², sur combien de mètres le "
        "robot s’arrête-t-il ?",
        answer=react + stop,
        unit="m",
        tolerance=0.02,
        why=f"Réaction : {number(react)} m ; freinage : v²/(2a) = {number(stop)} m.",
        wrong=(
            WrongAnswer(stop, "Pendant la réaction, le robot roule encore."),
            WrongAnswer(react, "C’est la réaction seule ; il faut encore freiner."),
            WrongAnswer(react + 2 * stop, "Le freinage prend v²/(2a), non v²/a."),
        ),
    )


def sans_mur(rng: np.random.Generator) -> RetrievalQuestion:
    rays = int(rng.choice([180, 360, 720]))
    return RetrievalQuestion(
        text=f"Sur {rays} rayons, un seul, devant, lit « −inf ». Que fait un nœud d’arrêt prudent ?",
        answer="Il s’arrête : l’obstacle est trop près pour être mesuré",
        why="La REP 117 réserve −inf à ce qui est trop près, et +inf à ce qui n’a rien rencontré.",
        wrong=(
            WrongAnswer(
                "Il l’ignore : la lecture est invalide",
                "C’est au moment où l’on touche presque que l’on relâcherait le frein.",
            ),
            WrongAnswer("Il continue : le rayon n’a rien rencontré", "C’est +inf qui le dit ; −inf dit l’inverse."),
        ),
    )


def repere_date(rng: np.random.Generator) -> RetrievalQuestion:
    late, speed = 100 * int(rng.integers(1, 5)), int(rng.choice([1, 2]))
    return RetrievalQuestion(
        text=f"Un scan est traité {late} ms après avoir été pris, et le robot roule à {speed} m/s. De combien "
        "de mètres se trompe-t-on en le "
        "plaçant à la pose de maintenant ?",
        answer=speed * late / 1000,
        unit="m",
        why="On demande à tf2 la pose à la date du scan : le robot a roulé depuis.",
        wrong=(
            WrongAnswer(0.0, "La pose a changé depuis que le scan a été pris."),
            WrongAnswer(speed * late / 100, "Cent millisecondes font un dixième de seconde."),
        ),
    )


def gonfler(rng: np.random.Generator) -> RetrievalQuestion:
    radius, cell = 5 * int(rng.integers(3, 7)), 5
    return RetrievalQuestion(
        text=f"Le robot a un rayon de {radius} cm, les cases font {cell} cm. De combien de cases gonfler les "
        "obstacles, pour chercher ensuite "
        "le chemin d’un point ?",
        answer=float(radius // cell),
        tolerance=0.1,
        why="De son rayon : son centre ne peut approcher d’un mur davantage.",
        wrong=(
            WrongAnswer(float(2 * radius // cell), "C’est le diamètre ; le centre n’est qu’à un rayon du bord."),
            WrongAnswer(float(radius), "C’est le rayon en centimètres : il faut des cases."),
        ),
    )
