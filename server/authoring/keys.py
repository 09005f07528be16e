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
class Key:
    """`example` is TOML, as one writes it after `key = `."""

    meaning: str
    example: str

    @property
    def value(self) -> Any:
        return tomllib.loads(f"key = {self.example}")["key"]


Keys = Mapping[str, Key]

ID = Key("nom, par lequel on parle de lui ailleurs", '"bouts_echanges"')
MISTAKE = {
    "title": Key("ce que l’élève lit d’abord : l’erreur, en quelques mots", '"Le départ et l’arrivée sont échangés"'),
    "explanation": Key("pourquoi c’est faux", '"Pour t = 0, on doit être en a."'),
    "question": Key("la question qui le fait voir", '"Que renvoie votre fonction pour t = 0 ?"'),
}
EDITS = Key(
    "des façons de la commettre : chacune, des textes de `model.py` à remplacer, chacun suivi de ce qui le remplace",
    '[["a + t * (b - a)", "b + t * (a - b)"]]',
)
AFTER = Key("ses textes ne se trouvent qu’une fois une autre erreur commise", "true")
OPTIONS = '[{ id = "a", text = "4", why = "oui" }, { id = "b", text = "2", why = "non" }]'

KEYS: Mapping[type[BaseModel], Keys] = {
    ModuleFile: {
        "title": Key("titre du module", '"Où suis-je ? Localisation, cartographie, SLAM"'),
        "number": Key("son numéro, comme on le dit", '"L20"'),
        "summary": Key("une ou deux phrases, pour la page d’accueil", '"Un robot doit savoir où il est."'),
        "track": Key("le parcours où il se place", '"Lycée → prépa"'),
        "sessions": Key("nombre de séances", "4"),
        "prerequisites": Key("ce qu’il faut savoir avant", '["L10 : matrices et rotations"]'),
        "objectives": Key("ce que l’on saura faire après", '["Localiser un robot sur une carte connue."]'),
        "references": Key(
            "livres, cours et articles, en Markdown d’une ligne",
            '["Probabilistic Robotics, de Thrun, Burgard et Fox (2005)."]',
        ),
        "paths": Key(
            "des chemins à travers le module, une table chacun",
            '[{ title = "En terminale", summary = "L’essentiel.", page = "chemins" }]',
        ),
        "previous": Key("numéro du module d’avant", '"L19"'),
        "next": Key("numéro du module d’après", '"L21"'),
        "order": Key("sa place parmi les modules, si ce n’est celle de son numéro", "20"),
    },
    PathEntry: {
        "name": Key("nom, par lequel une page dit ce que le chemin laisse pour plus tard", '"lycee"'),
        "title": Key("pour qui il est", '"En terminale"'),
        "summary": Key("une phrase : par où il passe", '"Les séances 1 et 2, sans les démonstrations."'),
        "page": Key("nom de la page qui le décrit", '"chemins"'),
        "exercises": Key("ses exercices, dans son ordre", '["odometrie", "lidar"]'),
    },
    TermEntry: {
        "id": Key("nom, pour les liens `[pose](terme:pose)`", '"pose"'),
        "mot": Key("le mot, comme on l’écrit", '"pose"'),
        "definition": Key(
            "sa définition, en Markdown : un paragraphe", "'Position et orientation, $(x, y, \\theta)$.'"
        ),
        "page": Key("nom de la page qui l’explique", '"definitions"'),
    },
    FrontMatter: {
        "title": Key("titre de la page, sans formule ni code", '"Localiser : où suis-je sur cette carte ?"'),
        "label": Key("nom court, pour les menus", '"Séance 1"'),
        "summary": Key("une phrase : ce que l’on y apprend", '"Une croyance, et comment une mesure la change."'),
        "order": Key("sa place parmi les pages de cette sorte", "10"),
        "minutes": Key("durée, en minutes, d’un sujet, d’un TP ou d’un défi", "120"),
        "objectives": Key("ce que l’on saura faire après", '["Écrire un filtre bayésien sur une grille."]'),
        "objective": Key(
            "au lieu d’`objectives` : une table par objectif, avec ses exercices (voir plus bas)",
            '[{ id = "poses", text = "Composer des poses.", short = "Les poses", exercises = ["poses"] }]',
        ),
        "solution": Key("ce qu’elle dit reste fermé à une classe jusqu’à ce qu’on l’ouvre", "true"),
    },
    ObjectiveEntry: {
        "id": Key("nom, unique dans le module", '"poses"'),
        "text": Key("ce que l’on saura faire, à l’infinitif", '"Composer, inverser et comparer des poses."'),
        "short": Key("le même en quelques mots, pour les tableaux", '"Composer des poses"'),
        "exercises": Key(
            "exercices dont la réussite le montre ; `exercice:fonction` n’en prend que les erreurs de cette fonction",
            '["poses", "metriques:rpe"]',
        ),
        "mistakes": Key(
            "erreurs d’autres exercices qui le concernent ; d’un exercice nommé ici, celles-là seulement",
            '["verification/angle_non_ramene"]',
        ),
    },
    ExerciseFile: {
        "title": Key("titre de l’exercice", '"Composer, inverser et comparer des poses"'),
        "summary": Key("une phrase : ce que l’on y fait", '"Passer d’un repère à l’autre dans le plan."'),
        "order": Key("sa place parmi les exercices du module", "10"),
        "stars": Key("difficulté d’un défi, de 1 à 3 ; 0 pour un exercice", "1"),
        "origin": Key("d’où il vient", '"Exercice 3"'),
        "kind": Key('"code", ou "answers" pour un exercice sans code', '"answers"'),
        "seance": Key("nom de la page après laquelle il vient", '"localiser"'),
        "functions": Key(
            "les fonctions à écrire, une table chacune", '[{ name = "inverse", signature = "inverse(a)" }]'
        ),
        "reuses": Key("exercices dont ses programmes peuvent importer les fonctions de `mes_fonctions`", '["poses"]'),
        "limits": Key("limites propres à cet exercice (voir la table plus bas)", "{ cpu_seconds = 20.0 }"),
        "hunts": Key("qui voit ses chasses aux erreurs : personne, qui l’a réussi (par défaut), ou tous", '"never"'),
    },
    FunctionEntry: {
        "name": Key("nom de la fonction, ou de la classe", '"inverse"'),
        "signature": Key("comment elle s’appelle, telle qu’elle est montrée", '"inverse(a)"'),
        "returns": Key("ce qu’elle renvoie, en mots", '"une pose (3,)"'),
        "doc": Key("ce qu’elle fait, en une phrase", '"la pose qui, composée avec a, donne (0, 0, 0)"'),
        "parts": Key("noms des valeurs, si elle en renvoie plusieurs", '["R", "t"]'),
        "example": Key("un appel, valeurs comprises, que l’élève peut rejouer pas à pas", '"inverse((1, 2, pi / 2))"'),
    },
    questions.ChoiceFile: {
        "form": Key("la sorte de questions", '"choice"'),
        "question": Key("les questions, une table chacune", f'[{{ id = "a", text = "?", option = {OPTIONS} }}]'),
    },
    questions.ChoiceEntry: {
        "id": ID,
        "title": Key("titre ; sans lui, « Question 1 »", '"La dérive de l’odométrie"'),
        "text": Key("la question, en Markdown", '"Où est-on au quart du chemin ?"'),
        "points": Key("son poids parmi les autres", "2.0"),
        "several": Key("plusieurs réponses sont à cocher", "true"),
        "section": Key("titre du groupe auquel elle appartient", '"Localiser"'),
        "hint": Key("piste, montrée après une réponse fausse", '"Quelle est la longueur du chemin ?"'),
        "option": Key("les réponses proposées, deux au moins", OPTIONS),
    },
    questions.OptionEntry: {
        "id": ID,
        "right": Key("c’est une bonne réponse", "true"),
        "text": Key("la réponse, en Markdown", '"En $4$."'),
        "why": Key("pourquoi elle est juste, ou fausse", '"Oui : $2 + 2 = 4$."'),
        "misconception": Key("l’erreur qu’elle montre, de `misconceptions.toml`", '"depart_oublie"'),
    },
    questions.OrderFile: {
        "form": Key("la sorte de questions", '"order"'),
        "instruction": Key("ce que l’on demande, s’il faut le dire autrement", '"Remettez les étapes dans l’ordre."'),
        "step": Key(
            "les étapes, dans un bon ordre",
            '[{ id = "a", text = "$x$", role = "poser" }, { id = "b", text = "$y$", role = "conclure" }]',
        ),
        "distractor": Key("les étapes fausses", '[{ id = "b", text = "$y$", why = "non" }]'),
    },
    questions.StepEntry: {
        "id": ID,
        "text": Key("l’étape, en Markdown", '"Le chemin vaut $b - a$."'),
        "role": Key("à quoi elle sert, à l’infinitif : dit quand elle manque", '"écrire le chemin entier"'),
        "after": Key("les étapes dont elle a besoin ; sans elle, celle qui précède", '["chemin"]'),
    },
    questions.DistractorEntry: {
        "id": ID,
        "text": Key("l’étape fausse, en Markdown", '"On est en $\\\\frac12(b - a)$."'),
        "why": Key("pourquoi elle est fausse", '"Il manque le point de départ."'),
        "misconception": Key("l’erreur qu’elle montre, de `misconceptions.toml`", '"depart_oublie"'),
    },
    questions.NumericFile: {
        "form": Key("la sorte de questions", '"numeric"'),
        "data": Key("les nombres tirés", '[{ name = "a", symbol = "a", meaning = "le départ" }]'),
        "question": Key("les questions, une table chacune", '[{ id = "point", text = "Où ?" }]'),
    },
    questions.DatumEntry: {
        "name": Key("nom que `deal()` lui donne, et `{{nom}}` dans les textes", '"a"'),
        "symbol": Key("son symbole, en TeX", '"\\\\sigma_x"'),
        "unit": Key("son unité", '"m"'),
        "digits": Key("décimales montrées", "2"),
        "meaning": Key("ce qu’il est, en mots", '"le départ"'),
    },
    questions.NumericEntry: {
        "id": Key("nom de la `Quantity` qui la corrige", '"point"'),
        "title": Key("titre ; sans lui, « Question 1 »", '"Où l’on s’arrête"'),
        "text": Key("la question, en Markdown, avec ses `{{nombres}}`", '"Où est-on à la fraction {{t}} du chemin ?"'),
        "unit": Key("unité de la réponse", '"m"'),
        "hint": Key("piste, montrée après une réponse fausse", '"Quelle est la longueur du chemin ?"'),
        "correction": Key("la correction, où `{{id}}` est la réponse", '"$a + t\\\\,(b - a) = {{point}}$."'),
    },
    shapes.MisconceptionsFile: {
        "misconception": Key(
            "les erreurs qui ont un nom",
            '[{ id = "a", functions = ["f"], title = "T", explanation = "E", question = "Q" }]',
        ),
        "slip": Key(
            "des étourderies courantes, dont les mots sont connus", '[{ id = "degres", edits = [["a", "b"]] }]'
        ),
        "style": Key("des façons d’écrire `model.py` qui restent justes", '[{ edits = [["a + b", "b + a"]] }]'),
    },
    shapes.MisconceptionEntry: {
        "id": ID,
        "functions": Key("les fonctions où on la commet", '["gain"]'),
        **MISTAKE,
        "edits": EDITS,
        "ruled": Key("seule une règle des sondes (`probes.py`) la reconnaît", "true"),
        "right": Key("les vérifications que ses mots disent justes : si l’une échoue, le nom est retiré", '["sommes"]'),
        "alone": Key(
            "les bouts de son explication qui ne sont vrais que sans autre erreur : à côté d’une autre, on les tait",
            '["Les bouts sont justes, mais "]',
        ),
        "after": AFTER,
    },
    shapes.SlipEntry: {
        "id": Key("l’étourderie, de `graders/core/compare/slips.py`", '"degres"'),
        "edits": EDITS,
        "functions": Key("les fonctions où on la commet ; toutes sans elle", '["gain"]'),
        "after": AFTER,
    },
    shapes.StyleEntry: {"edits": EDITS},
    shapes.MistakesFile: {
        "misconception": Key(
            "les erreurs qui ont un nom", '[{ id = "a", title = "T", explanation = "E", question = "Q" }]'
        ),
    },
    shapes.MistakeEntry: {"id": ID, **MISTAKE},
    shapes.EquivalentsFile: {
        "equivalent": Key(
            "les altérations de la solution qui restent justes",
            '[{ function = "f", removed = "a", added = "b", reason = "R" }]',
        ),
    },
    shapes.EquivalentEntry: {
        "function": Key("la fonction où elle est, vide hors de toutes", '"candidats_boucle"'),
        "removed": Key("la ligne d’avant, sans sa marge", '"if distance <= seuil:"'),
        "added": Key("la ligne d’après", '"if distance < seuil:"'),
        "reason": Key("pourquoi c’est encore juste", '"L’énoncé accepte les deux inégalités."'),
    },
    FamiliesFile: {
        "family": Key(
            "les familles, une table chacune", '[{ id = "degres", title = "Des degrés", summary = "180° valent π." }]'
        ),
    },
    FamilyEntry: {
        "id": Key("nom, sous lequel les exercices y rangent leurs erreurs", '"degres"'),
        "title": Key("l’erreur commune, en quelques mots", '"Des degrés et des radians sont mêlés"'),
        "summary": Key("une phrase : ce qu’il faut en retenir", '"Les fonctions cos et sin attendent des radians."'),
        "slips": Key("les étourderies de `graders/core/compare/slips.py` qui en sont", '["degres"]'),
    },
    ExerciseFamiliesFile: {
        "families": Key("par famille, les erreurs de l’exercice qui en sont", '{ degres = ["degres_dans_cos"] }'),
        "apart": Key("par raison, les erreurs qui n’ont pas de famille", '{ "propre à cet exercice" = ["arc_exact"] }'),
    },
    PolicyEntry: {name: Key(row.label.lower(), f"{getattr(Policy(), name)}") for name, row in LIMIT_SPECS.items()},
    shapes.GlossaryFile: {
        "terme": Key(
            "les mots, une table chacun", '[{ id = "pose", mot = "pose", definition = "D", page = "definitions" }]'
        )
    },
}
