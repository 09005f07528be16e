"""The tables of keys in the authors' pages, made from the models and the classes themselves.

`python -m server.authoring.tables` writes them where a page says `<!-- table: Name -->`; a test holds them so.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from graders.core.answers.quantity import Quantity
from graders.core.code.checks import Cases, Check, Trial, Untouched
from graders.core.code.probes import Probes
from graders.core.compare import comparison, plain_values, shrinking
from graders.core.contract.outcomes import Outcome
from graders.robotics import poses
from server.authoring.keys import KEYS
from server.base.files import ROOT
from server.course.kinds import KINDS
from server.sandbox.policy import LIMIT_SPECS, Policy

PAGES = ROOT / "server" / "docs" / "auteurs"
MARK = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- fin -->)", re.DOTALL)
TYPES = {
    "string": "texte", "integer": "entier", "number": "nombre", "boolean": "vrai ou faux", "array": "liste",
    "object": "table", "null": "",
}  # fmt: skip

#: What each field of a class of the graders is, in French.
FIELD_MEANINGS: Mapping[type, Mapping[str, str]] = {
    Check: {
        "id": "nom, unique dans l’exercice",
        "title": "ce que l’élève lit de la vérification",
        "points": "sur 20 ; tous font 20",
        "functions": "les fonctions qu’elle juge",
        "hint": "une question, montrée quand elle échoue",
    },
    Cases: {
        "names": "noms des arguments, dans les contre-exemples",
        "cases": "`cases(rng)` donne des tuples d’arguments, du plus simple au plus général",
        "expected": "`expected(*arguments)` calcule la bonne réponse",
        "compare": "un comparateur (voir plus bas)",
        "shrinkers": "un simplificateur par argument (voir plus bas)",
        "valid": "`valid(arguments)` : un cas simplifié reste-t-il un cas que l’énoncé permet ?",
        "figure": "`figure(arguments, attendu, obtenu)` donne les données d’un dessin de `figures.py`",
        "rows": "`expected` accepte aussi des tableaux, un cas par ligne : les bonnes réponses sont vues d’un coup",
    },
    Trial: {
        "protocol": "`protocol(bench)` appelle les fonctions, et lève `Rejection` si ce n’est pas bon",
        "asks": "`asks(bench)` tire d’avance les appels (`PlannedCalls`) qui ne dépendent d’aucune réponse",
        "no_more": "un programme juste n’est appelé que par ceux-là",
    },
    Untouched: {
        "names": "noms des arguments de chaque fonction",
        "inputs": "`inputs(rng)` donne les arguments de chaque fonction",
        "then": "`then(rng)` donne les arguments d’un second appel, qui doit laisser intact le résultat du premier ; "
        "sans elle, `inputs` encore",
        "chance": "les fonctions qui tirent au hasard : elles sont appelées plusieurs fois avant",
    },
    Quantity: {
        "id": "nom de la question, dans `questions.toml`",
        "points": "sur 20 ; tous font 20",
        "expected": "`expected(data, earlier)` : la réponse, d’après les nombres tirés et les réponses d’avant",
        "rel": "tolérance, en fraction de la réponse",
        "abs": "tolérance, en unités de la réponse",
        "angle": "comparée à 2π près",
        "slips": "formules fausses, par le nom de l’erreur qu’elles montrent",
    },
    Probes: {
        "function": "la fonction que l’on sonde",
        "calls": "les appels, toujours les mêmes",
        "kit": "les réglages de la trousse",
        "read": "`read(arguments, valeur)` : ce que l’on compare",
        "same": "deux réponses sont-elles la même ?",
        "rules": "des règles, pour ce qu’aucune erreur ne reproduit",
        "last_rules": "celles qui parlent en dernier",
        "random": "la fonction tire au hasard",
        "unless": "rien n’est demandé si une vérification de l’une d’elles seule a échoué",
        "facet": "une partie de la réponse, sur laquelle certaines erreurs ne pèsent pas",
        "compared": "combien d’appels sont comparés aux erreurs ; tous, sans lui",
        "given": "des noms pour les erreurs seules",
        "unique": "l’énoncé fixe la réponse ; `False` si d’autres que celle du corrigé sont justes",
        "faults": "les réponses qui remplacent une exception, par son nom, quand un arrondi décide des deux",
    },
}
COMPARATORS = (
    comparison.CloseTo, comparison.ScalarCloseTo, comparison.SameIndices, plain_values.SamePlainValue, poses.SamePose,
)  # fmt: skip
SHRINKERS = (
    shrinking.keep_unchanged, shrinking.shrink_number, shrinking.shrink_array, shrinking.shrink_text,
    shrinking.shrink_plain_value, poses.shrink_pose,
)  # fmt: skip
#: What the docstrings say, in French.
FRENCH_SUMMARIES = {
    "CloseTo": "tableaux ou nombres de même forme et, à la tolérance près, de mêmes valeurs",
    "ScalarCloseTo": "un nombre, à la tolérance près (`float`, `int`, scalaire de numpy, tableau 0-d)",
    "SameIndices": "les mêmes entiers, dans le même ordre",
    "SamePlainValue": "n’importe quelles valeurs simples : textes, dictionnaires, ensembles, listes dans un ordre "
    'libre avec `order="any"`, nombres à la tolérance près',
    "SamePose": "une pose (x, y, θ), l’angle modulo 2π (de `graders.robotics.poses`)",
    "keep_unchanged": "ne simplifie pas cet argument",
    "shrink_number": "un nombre plus simple : 0, 1, moins de décimales",
    "shrink_array": "un tableau plus petit, de nombres plus simples",
    "shrink_text": "un texte plus court",
    "shrink_plain_value": "une valeur plus simple de la même sorte : une liste ou un texte plus courts, un nombre…",
    "shrink_pose": "une pose plus simple (de `graders.robotics.poses`)",
}


def render_table(name: str) -> str:
    """One table, in Markdown. Raises KeyError for what there is none of."""
    made = {
        "Comparateurs": _comparator_table,
        "Simplificateurs": _shrinker_table,
        "Limites": _limit_table,
        "Issues": _outcome_table,
    }
    if name in made:
        return made[name]()
    if name == "Pages":
        rows = [[f"`{kind.folder}/`", kind.shelf or "séances, sur la page du module"] for kind in KINDS]
        return _markdown_table(["dossier", "ce qui s’y lit"], rows)
    models = {model.__name__: model for model in KEYS}
    return (
        _pydantic_model_table(models[name])
        if name in models
        else _dataclass_table({kind.__name__: kind for kind in FIELD_MEANINGS}[name])
    )


def _markdown_table(heads: list[str], rows: list[list[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines) + "\n"


def _pydantic_model_table(model: type[BaseModel]) -> str:
    schema = model.model_json_schema()
    required = set(schema.get("required", ()))
    rows = [
        [
            f"`{name}`" + (" *" if name in required else ""),
            _french_type(schema, schema["properties"][name]),
            KEYS[model][name].meaning,
            f"`{name} = {KEYS[model][name].example}`",
        ]
        for name in model.model_fields
    ]
    return _markdown_table(["clé", "type", "ce que c’est", "exemple"], rows)


def _french_type(schema: Mapping[str, Any], value: Mapping[str, Any]) -> str:
    if "$ref" in value:
        return _french_type(schema, schema["$defs"][value["$ref"].rsplit("/", 1)[1]])
    if "anyOf" in value:
        return " ou ".join(dict.fromkeys(filter(None, (_french_type(schema, option) for option in value["anyOf"]))))
    if "const" in value or "enum" in value:
        return " ou ".join(f"`{choice}`" for choice in value.get("enum", [value.get("const")]))
    if value.get("type") == "array" and "items" in value:
        inside = _french_type(schema, value["items"])
        return f"liste de {inside}s" if " " not in inside else f"liste ({inside})"
    return TYPES[value["type"]]


def _dataclass_table(kind: type) -> str:
    inherited = {name for base in kind.__mro__[1:] for name in getattr(base, "__dataclass_fields__", {})}
    rows = [
        [
            f"`{field.name}`" + (" *" if _is_required_field(field) else ""),
            f"`{field.type}`",
            FIELD_MEANINGS[kind][field.name],
        ]
        for field in dataclasses.fields(kind)
        if field.name not in inherited
    ]
    return _markdown_table(["paramètre", "type", "ce que c’est"], rows)


def _is_required_field(field: dataclasses.Field[Any]) -> bool:
    return field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


def _comparator_table() -> str:
    rows = [
        [
            f"`{comparator.__name__}{inspect.signature(comparator)}`".replace(" -> None", ""),
            FRENCH_SUMMARIES[comparator.__name__],
        ]
        for comparator in COMPARATORS
    ]
    return _markdown_table(["comparateur", "accepte"], rows)


def _shrinker_table() -> str:
    return _markdown_table(
        ["simplificateur", "essaie"],
        [[f"`{shrinker.__name__}`", FRENCH_SUMMARIES[shrinker.__name__]] for shrinker in SHRINKERS],
    )


def _limit_table() -> str:
    default = Policy()
    rows = [
        [f"`{name}`", row.label, str(getattr(default, name)), f"{row.minimum:g} à {row.maximum:g}"]
        for name, row in LIMIT_SPECS.items()
    ]
    return _markdown_table(["clé", "ce que c’est", "sans elle", "permis"], rows)


def _outcome_table() -> str:
    return _markdown_table(
        ["dossier", "verdict"], [[f"`{outcome.value}/`", outcome.wording("code").title] for outcome in Outcome]
    )


def replace_tables_in_page(text: str) -> str:
    """A page with its tables made anew."""
    return MARK.sub(lambda found: f"{found[1]}{render_table(found[2])}{found[3]}", text)


def main(pages: Path = PAGES) -> None:
    for path in sorted(pages.glob("*.md")):
        path.write_text(replace_tables_in_page(path.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
