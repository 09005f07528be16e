"""What each key of an author's TOML files means, in French, with an example: for the pages, and for editors."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from server.authoring import shapes
from server.course import questions
from server.course.schemas import (
    ExerciseFamiliesFile,
    ExerciseFile,
    FamiliesFile,
    FamilyEntry,
    FrontMatter,
    FunctionEntry,
    ModuleFile,
    ObjectiveEntry,
    PathEntry,
    PolicyEntry,
    TermEntry,
)
from server.sandbox.policy import LIMIT_SPECS, Policy


@dataclass(frozen=True)
class DocumentedKey:
    """`example` is TOML, as one writes it after `key = `."""

    meaning: str
    example: str

    @property
    def example_value(self) -> Any:
        return tomllib.loads(f"key = {self.example}")["key"]


Keys = Mapping[str, DocumentedKey]

ID = DocumentedKey("nom, par lequel on parle de lui ailleurs", '"bouts_echanges"')
MISTAKE = {
    "title": DocumentedKey(
        "ce que l’élève lit d’abord : l’erreur, en quelques mots", '"Le départ et l’arrivée sont échangés"'
    ),
    "explanation": DocumentedKey("pourquoi c’est faux", '"Pour t = 0, on doit être en a."'),
    "question": DocumentedKey("la question qui le fait voir", '"Que renvoie votre fonction pour t = 0 ?"'),
}
EDITS = DocumentedKey(
    "des façons de la commettre : chacune, des textes de `model.py` à remplacer, chacun suivi de ce qui le remplace",
    '[["a + t * (b - a)", "b + t * (a - b)"]]',
)
AFTER = DocumentedKey("ses textes ne se trouvent qu’une fois une autre erreur commise", "true")
OPTIONS = '[{ id = "a", text = "4", why = "oui" }, { id = "b", text = "2", why = "non" }]'

KEYS: Mapping[type[BaseModel], Keys] = {
    ModuleFile: {
        "title": DocumentedKey("titre du module", '"Où suis-je ? Localisation, cartographie, SLAM"'),
        "number": DocumentedKey("son numéro, comme on le dit", '"L20"'),
        "summary": DocumentedKey("une ou deux phrases, pour la page d’accueil", '"Un robot doit savoir où il est."'),
        "track": DocumentedKey("le parcours où il se place", '"Lycée → prépa"'),
        "sessions": DocumentedKey("nombre de séances", "4"),
        "prerequisites": DocumentedKey("ce qu’il faut savoir avant", '["L10 : matrices et rotations"]'),
        "objectives": DocumentedKey("ce que l’on saura faire après", '["Localiser un robot sur une carte connue."]'),
        "references": DocumentedKey(
            "livres, cours et articles, en Markdown d’une ligne",
            '["Probabilistic Robotics, de Thrun, Burgard et Fox (2005)."]',
        ),
        "paths": DocumentedKey(
            "des chemins à travers le module, une table chacun",
            '[{ title = "En terminale", summary = "L’essentiel.", page = "chemins" }]',
        ),
        "previous": DocumentedKey("numéro du module d’avant", '"L19"'),
        "next": DocumentedKey("numéro du module d’après", '"L21"'),
        "order": DocumentedKey("sa place parmi les modules, si ce n’est celle de son numéro", "20"),
    },
    PathEntry: {
        "name": DocumentedKey("nom, par lequel une page dit ce que le chemin laisse pour plus tard", '"lycee"'),
        "title": DocumentedKey("pour qui il est", '"En terminale"'),
        "summary": DocumentedKey("une phrase : par où il passe", '"Les séances 1 et 2, sans les démonstrations."'),
        "page": DocumentedKey("nom de la page qui le décrit", '"chemins"'),
        "exercises": DocumentedKey("ses exercices, dans son ordre", '["odometrie", "lidar"]'),
    },
    TermEntry: {
        "id": DocumentedKey("nom, pour les liens `[pose](terme:pose)`", '"pose"'),
        "mot": DocumentedKey("le mot, comme on l’écrit", '"pose"'),
        "definition": DocumentedKey(
            "sa définition, en Markdown : un paragraphe", "'Position et orientation, $(x, y, \\theta)$.'"
        ),
        "page": DocumentedKey("nom de la page qui l’explique", '"definitions"'),
    },
    FrontMatter: {
        "title": DocumentedKey("titre de la page, sans formule ni code", '"Localiser : où suis-je sur cette carte ?"'),
        "label": DocumentedKey("nom court, pour les menus", '"Séance 1"'),
        "summary": DocumentedKey(
            "une phrase : ce que l’on y apprend", '"Une croyance, et comment une mesure la change."'
        ),
        "order": DocumentedKey("sa place parmi les pages de cette sorte", "10"),
        "minutes": DocumentedKey("durée, en minutes, d’un sujet, d’un TP ou d’un défi", "120"),
        "objectives": DocumentedKey("ce que l’on saura faire après", '["Écrire un filtre bayésien sur une grille."]'),
        "objective": DocumentedKey(
            "au lieu d’`objectives` : une table par objectif, avec ses exercices (voir plus bas)",
            '[{ id = "poses", text = "Composer des poses.", short = "Les poses", exercises = ["poses"] }]',
        ),
        "solution": DocumentedKey("ce qu’elle dit reste fermé à une classe jusqu’à ce qu’on l’ouvre", "true"),
    },
    ObjectiveEntry: {
        "id": DocumentedKey("nom, unique dans le module", '"poses"'),
        "text": DocumentedKey("ce que l’on saura faire, à l’infinitif", '"Composer, inverser et comparer des poses."'),
        "short": DocumentedKey("le même en quelques mots, pour les tableaux", '"Composer des poses"'),
        "exercises": DocumentedKey(
            "exercices dont la réussite le montre ; `exercice:fonction` n’en prend que les erreurs de cette fonction",
            '["poses", "metriques:rpe"]',
        ),
        "mistakes": DocumentedKey(
            "erreurs d’autres exercices qui le concernent ; d’un exercice nommé ici, celles-là seulement",
            '["verification/angle_non_ramene"]',
        ),
    },
    ExerciseFile: {
        "title": DocumentedKey("titre de l’exercice", '"Composer, inverser et comparer des poses"'),
        "summary": DocumentedKey("une phrase : ce que l’on y fait", '"Passer d’un repère à l’autre dans le plan."'),
        "order": DocumentedKey("sa place parmi les exercices du module", "10"),
        "stars": DocumentedKey("difficulté d’un défi, de 1 à 3 ; 0 pour un exercice", "1"),
        "origin": DocumentedKey("d’où il vient", '"Exercice 3"'),
        "kind": DocumentedKey('"code", ou "answers" pour un exercice sans code', '"answers"'),
        "seance": DocumentedKey("nom de la page après laquelle il vient", '"localiser"'),
        "functions": DocumentedKey(
            "les fonctions à écrire, une table chacune", '[{ name = "inverse", signature = "inverse(a)" }]'
        ),
        "reuses": DocumentedKey(
            "exercices dont ses programmes peuvent importer les fonctions de `mes_fonctions`", '["poses"]'
        ),
        "limits": DocumentedKey("limites propres à cet exercice (voir la table plus bas)", "{ cpu_seconds = 20.0 }"),
        "hunts": DocumentedKey(
            "qui voit ses chasses aux erreurs : personne, qui l’a réussi (par défaut), ou tous", '"never"'
        ),
    },
    FunctionEntry: {
        "name": DocumentedKey("nom de la fonction, ou de la classe", '"inverse"'),
        "signature": DocumentedKey("comment elle s’appelle, telle qu’elle est montrée", '"inverse(a)"'),
        "returns": DocumentedKey("ce qu’elle renvoie, en mots", '"une pose (3,)"'),
        "doc": DocumentedKey("ce qu’elle fait, en une phrase", '"la pose qui, composée avec a, donne (0, 0, 0)"'),
        "parts": DocumentedKey("noms des valeurs, si elle en renvoie plusieurs", '["R", "t"]'),
        "example": DocumentedKey(
            "un appel, valeurs comprises, que l’élève peut rejouer pas à pas", '"inverse((1, 2, pi / 2))"'
        ),
    },
    questions.ChoiceFile: {
        "form": DocumentedKey("la sorte de questions", '"choice"'),
        "question": DocumentedKey(
            "les questions, une table chacune", f'[{{ id = "a", text = "?", option = {OPTIONS} }}]'
        ),
    },
    questions.ChoiceEntry: {
        "id": ID,
        "title": DocumentedKey("titre ; sans lui, « Question 1 »", '"La dérive de l’odométrie"'),
        "text": DocumentedKey("la question, en Markdown", '"Où est-on au quart du chemin ?"'),
        "points": DocumentedKey("son poids parmi les autres", "2.0"),
        "several": DocumentedKey("plusieurs réponses sont à cocher", "true"),
        "section": DocumentedKey("titre du groupe auquel elle appartient", '"Localiser"'),
        "hint": DocumentedKey("piste, montrée après une réponse fausse", '"Quelle est la longueur du chemin ?"'),
        "option": DocumentedKey("les réponses proposées, deux au moins", OPTIONS),
    },
    questions.OptionEntry: {
        "id": ID,
        "right": DocumentedKey("c’est une bonne réponse", "true"),
        "text": DocumentedKey("la réponse, en Markdown", '"En $4$."'),
        "why": DocumentedKey("pourquoi elle est juste, ou fausse", '"Oui : $2 + 2 = 4$."'),
        "misconception": DocumentedKey("l’erreur qu’elle montre, de `misconceptions.toml`", '"depart_oublie"'),
    },
    questions.OrderFile: {
        "form": DocumentedKey("la sorte de questions", '"order"'),
        "instruction": DocumentedKey(
            "ce que l’on demande, s’il faut le dire autrement", '"Remettez les étapes dans l’ordre."'
        ),
        "step": DocumentedKey(
            "les étapes, dans un bon ordre",
            '[{ id = "a", text = "$x$", role = "poser" }, { id = "b", text = "$y$", role = "conclure" }]',
        ),
        "distractor": DocumentedKey("les étapes fausses", '[{ id = "b", text = "$y$", why = "non" }]'),
    },
    questions.StepEntry: {
        "id": ID,
        "text": DocumentedKey("l’étape, en Markdown", '"Le chemin vaut $b - a$."'),
        "role": DocumentedKey("à quoi elle sert, à l’infinitif : dit quand elle manque", '"écrire le chemin entier"'),
        "after": DocumentedKey("les étapes dont elle a besoin ; sans elle, celle qui précède", '["chemin"]'),
    },
    questions.DistractorEntry: {
        "id": ID,
        "text": DocumentedKey("l’étape fausse, en Markdown", '"On est en $\\\\frac12(b - a)$."'),
        "why": DocumentedKey("pourquoi elle est fausse", '"Il manque le point de départ."'),
        "misconception": DocumentedKey("l’erreur qu’elle montre, de `misconceptions.toml`", '"depart_oublie"'),
    },
    questions.NumericFile: {
        "form": DocumentedKey("la sorte de questions", '"numeric"'),
        "data": DocumentedKey("les nombres tirés", '[{ name = "a", symbol = "a", meaning = "le départ" }]'),
        "question": DocumentedKey("les questions, une table chacune", '[{ id = "point", text = "Où ?" }]'),
    },
    questions.DatumEntry: {
        "name": DocumentedKey("nom que `deal()` lui donne, et `{{nom}}` dans les textes", '"a"'),
        "symbol": DocumentedKey("son symbole, en TeX", '"\\\\sigma_x"'),
        "unit": DocumentedKey("son unité", '"m"'),
        "digits": DocumentedKey("décimales montrées", "2"),
        "meaning": DocumentedKey("ce qu’il est, en mots", '"le départ"'),
    },
    questions.NumericEntry: {
        "id": DocumentedKey("nom de la `Quantity` qui la corrige", '"point"'),
        "title": DocumentedKey("titre ; sans lui, « Question 1 »", '"Où l’on s’arrête"'),
        "text": DocumentedKey(
            "la question, en Markdown, avec ses `{{nombres}}`", '"Où est-on à la fraction {{t}} du chemin ?"'
        ),
        "unit": DocumentedKey("unité de la réponse", '"m"'),
        "hint": DocumentedKey("piste, montrée après une réponse fausse", '"Quelle est la longueur du chemin ?"'),
        "correction": DocumentedKey("la correction, où `{{id}}` est la réponse", '"$a + t\\\\,(b - a) = {{point}}$."'),
    },
    shapes.MisconceptionsFile: {
        "misconception": DocumentedKey(
            "les erreurs qui ont un nom",
            '[{ id = "a", functions = ["f"], title = "T", explanation = "E", question = "Q" }]',
        ),
        "slip": DocumentedKey(
            "des étourderies courantes, dont les mots sont connus", '[{ id = "degres", edits = [["a", "b"]] }]'
        ),
        "style": DocumentedKey(
            "des façons d’écrire `model.py` qui restent justes", '[{ edits = [["a + b", "b + a"]] }]'
        ),
    },
    shapes.MisconceptionEntry: {
        "id": ID,
        "functions": DocumentedKey("les fonctions où on la commet", '["gain"]'),
        **MISTAKE,
        "edits": EDITS,
        "ruled": DocumentedKey("seule une règle des sondes (`probes.py`) la reconnaît", "true"),
        "right": DocumentedKey(
            "les vérifications que ses mots disent justes : si l’une échoue, le nom est retiré", '["sommes"]'
        ),
        "alone": DocumentedKey(
            "les bouts de son explication qui ne sont vrais que sans autre erreur : à côté d’une autre, on les tait",
            '["Les bouts sont justes, mais "]',
        ),
        "after": AFTER,
    },
    shapes.SlipEntry: {
        "id": DocumentedKey("l’étourderie, de `graders/core/compare/slips.py`", '"degres"'),
        "edits": EDITS,
        "functions": DocumentedKey("les fonctions où on la commet ; toutes sans elle", '["gain"]'),
        "after": AFTER,
    },
    shapes.StyleEntry: {"edits": EDITS},
    shapes.MistakesFile: {
        "misconception": DocumentedKey(
            "les erreurs qui ont un nom", '[{ id = "a", title = "T", explanation = "E", question = "Q" }]'
        ),
    },
    shapes.MistakeEntry: {"id": ID, **MISTAKE},
    shapes.EquivalentsFile: {
        "equivalent": DocumentedKey(
            "les altérations de la solution qui restent justes",
            '[{ function = "f", removed = "a", added = "b", reason = "R" }]',
        ),
    },
    shapes.EquivalentEntry: {
        "function": DocumentedKey("la fonction où elle est, vide hors de toutes", '"candidats_boucle"'),
        "removed": DocumentedKey("la ligne d’avant, sans sa marge", '"if distance <= seuil:"'),
        "added": DocumentedKey("la ligne d’après", '"if distance < seuil:"'),
        "reason": DocumentedKey("pourquoi c’est encore juste", '"L’énoncé accepte les deux inégalités."'),
    },
    FamiliesFile: {
        "family": DocumentedKey(
            "les familles, une table chacune", '[{ id = "degres", title = "Des degrés", summary = "180° valent π." }]'
        ),
    },
    FamilyEntry: {
        "id": DocumentedKey("nom, sous lequel les exercices y rangent leurs erreurs", '"degres"'),
        "title": DocumentedKey("l’erreur commune, en quelques mots", '"Des degrés et des radians sont mêlés"'),
        "summary": DocumentedKey(
            "une phrase : ce qu’il faut en retenir", '"Les fonctions cos et sin attendent des radians."'
        ),
        "slips": DocumentedKey("les étourderies de `graders/core/compare/slips.py` qui en sont", '["degres"]'),
    },
    ExerciseFamiliesFile: {
        "families": DocumentedKey(
            "par famille, les erreurs de l’exercice qui en sont", '{ degres = ["degres_dans_cos"] }'
        ),
        "apart": DocumentedKey(
            "par raison, les erreurs qui n’ont pas de famille", '{ "propre à cet exercice" = ["arc_exact"] }'
        ),
    },
    PolicyEntry: {
        name: DocumentedKey(row.label.lower(), f"{getattr(Policy(), name)}") for name, row in LIMIT_SPECS.items()
    },
    shapes.GlossaryFile: {
        "terme": DocumentedKey(
            "les mots, une table chacun", '[{ id = "pose", mot = "pose", definition = "D", page = "definitions" }]'
        )
    },
}
