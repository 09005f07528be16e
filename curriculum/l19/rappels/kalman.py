"""Retrieval questions of the séance on the Kalman filter."""

from __future__ import annotations

import numpy as np

from graders.core.answers.retrieval import RetrievalQuestion, WrongAnswer


def part(rng: np.random.Generator) -> RetrievalQuestion:
    worse = int(rng.integers(2, 5))
    share = worse**2 / (worse**2 + 1)
    return RetrievalQuestion(
        text=f"Deux thermomètres ont pour écarts-types {worse} °C et 1 °C. Quelle part donner au second ?",
        answer=share,
        tolerance=0.006,
        why=f"On pèse par les variances : {worse**2} / ({worse**2} + 1).",
        wrong=(
            WrongAnswer(worse / (worse + 1), "Ce sont les variances qui pèsent, pas les écarts-types."),
            WrongAnswer(1 - share, "C’est la part du premier, le moins précis."),
            WrongAnswer(0.5, "La moyenne ordinaire donne trop au mauvais appareil."),
        ),
    )


def gain(rng: np.random.Generator) -> RetrievalQuestion:
    doubt, noise = int(rng.integers(2, 7)), int(rng.integers(1, 5))
    return RetrievalQuestion(
        text=f"Avant la mesure, la variance est {doubt} ; celle du bruit de mesure, {noise}. Que vaut le gain ?",
        answer=doubt / (doubt + noise) if doubt != noise else 0.5,
        tolerance=0.006,
        why=f"K = v / (v + r) = {doubt} / {doubt + noise}.",
        wrong=tuple(
            wrong
            for wrong in (
                WrongAnswer(noise / (doubt + noise), "C’est 1 − K : la part de ce que l’on croyait."),
                WrongAnswer(doubt / noise, "Il manque v au dénominateur : le gain ne dépasse jamais 1."),
            )
            if abs(float(wrong.answer) - doubt / (doubt + noise)) > 0.01
        ),
    )


def corriger(rng: np.random.Generator) -> RetrievalQuestion:
    believed, gap = int(rng.integers(2, 9)), int(rng.integers(2, 6))
    return RetrievalQuestion(
        text=f"On croyait {believed} m, on lit {believed + gap} m, et le gain vaut 0,25. Que croit-on maintenant ?",
        answer=believed + gap / 4,
        unit="m",
        tolerance=0.02,
        why=f"On fait un quart du chemin vers la mesure : {believed} + 0,25 × {gap}.",
        wrong=(
            WrongAnswer(
                believed + 3 * gap / 4,
                "Le gain est la part de l’innovation que l’on retient, non celle que l’on laisse.",
            ),
            WrongAnswer(float(believed + gap), "Ce serait un gain de 1 : recopier la mesure."),
        ),
    )


def marcher(rng: np.random.Generator) -> RetrievalQuestion:
    a, b, c = ((3, 4, 5), (6, 8, 10), (5, 12, 13))[int(rng.integers(3))]
    return RetrievalQuestion(
        text=f"La position est connue à {a} cm près, en écart-type. Un pas ajoute une erreur indépendante de "
        f"{b} cm. Et maintenant ?",
        answer=float(c),
        unit="cm",
        tolerance=0.1,
        why=f"Les variances s’ajoutent : √({a}² + {b}²) = {c}.",
        wrong=(
            WrongAnswer(float(a + b), "Vous avez ajouté les écarts-types : ce sont les variances qui s’ajoutent."),
            WrongAnswer(float(a * a + b * b), "C’est la variance : il reste à prendre la racine."),
        ),
    )


def palier(rng: np.random.Generator) -> RetrievalQuestion:
    times = int(rng.integers(3, 9)) * 10
    return RetrievalQuestion(
        text=f"Un filtre part {times} fois plus incertain qu’un autre, avec les mêmes bruits. Où finit sa variance ?",
        answer="Au même palier que l’autre",
        why="Une correction retire d’autant plus qu’il y a de doute à retirer : le palier ne dépend que des "
        "deux bruits.",
        wrong=(
            WrongAnswer(f"{times} fois plus haut", "L’écart de départ s’efface en quelques corrections."),
            WrongAnswer("À zéro, après assez de pas", "Chaque prédiction ajoute du doute : on n’y arrive jamais."),
        ),
    )


def formes(rng: np.random.Generator) -> RetrievalQuestion:
    state, measure = int(rng.integers(4, 7)), int(rng.integers(2, 4))
    return RetrievalQuestion(
        text=f"L’état a {state} nombres, la mesure {measure}. Quelle est la forme du gain K ?",
        answer=f"{state} × {measure}",
        why="K transforme une innovation en correction d’état.",
        wrong=(
            WrongAnswer(f"{measure} × {state}", "C’est la forme de H, qui va de l’état à la mesure."),
            WrongAnswer(f"{state} × {state}", "C’est la forme de P et de F."),
            WrongAnswer(f"{measure} × {measure}", "C’est la forme de S et de R."),
        ),
    )


def balise(rng: np.random.Generator) -> RetrievalQuestion:
    scale = int(rng.integers(1, 5))
    return RetrievalQuestion(
        text=f"Le robot est en (0 ; 0), une balise en ({3 * scale} ; {4 * scale}). Quelle est la dérivée de la "
        "distance par rapport à son x ?",
        answer=-0.6,
        tolerance=0.006,
        why="C’est −(écart en x) / distance : avancer vers la balise la rapproche.",
        wrong=(
            WrongAnswer(0.6, "Le signe : s’avancer vers la balise diminue la distance."),
            WrongAnswer(-0.8, "C’est la dérivée par rapport à y."),
            WrongAnswer(-3.0 * scale, "Il reste à diviser par la distance."),
        ),
    )


def portillon(rng: np.random.Generator) -> RetrievalQuestion:
    gap, spread = int(rng.integers(4, 9)), int(rng.choice([2, 3]))
    return RetrievalQuestion(
        text=f"L’innovation est de {gap} m, et son écart-type attendu de {spread} m. Que vaut le carré réduit "
        "que compare le portillon ?",
        answer=(gap / spread) ** 2,
        tolerance=0.03,
        why=f"y² / S, où S est une variance : {gap}² / {spread}².",
        wrong=(
            WrongAnswer(gap * gap / spread, "S est une variance : il faut le carré de l’écart-type."),
            WrongAnswer(gap / spread, "Il manque le carré."),
        ),
    )
