"""The verdict's JSON (contract, section 3) in words and tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from server.web import values
from server.web.schemas import CheckView, CounterexampleView, DiagnosisView, FigureView, Texts, Tone, VerdictView
from server.web.words import points

OUTCOMES = {
    "ok": ("Exercice réussi", "Toutes les vérifications passent. Bravo !"),
    "wrong_answer": ("Réponse à revoir", "Votre code s’exécute, mais certains résultats ne sont pas les bons."),
    "syntax_error": ("Erreur de syntaxe", "Python n’a pas pu lire votre fichier : rien n’a été exécuté."),
    "import_error": ("Importation impossible", "Votre code importe un module qui n’est pas disponible ici."),
    "missing_function": ("Fonction manquante", "Une des fonctions demandées n’est pas définie dans votre fichier."),
    "runtime_error": ("Erreur à l’exécution", "Votre code s’est arrêté sur une exception."),
    "timeout": ("Temps dépassé", "Votre code n’a pas terminé dans le temps accordé : cherchez une boucle sans fin."),
    "memory_limit": ("Mémoire dépassée", "Votre code demande plus de mémoire qu’il n’en est accordé."),
    "output_limit": ("Réponse trop volumineuse", "Ce que renvoie votre code est trop gros pour être lu."),
    "forbidden_operation": (
        "Opération interdite",
        "Votre code a tenté une opération qui n’est pas autorisée ici.",
    ),
    "invalid_output": ("Résultat illisible", "Une fonction ne renvoie pas ce qui est demandé (type ou forme)."),
    "internal_error": (
        "Incident de notre côté",
        "La correction n’a pas pu aller à son terme. Cet essai ne compte pas : vous pouvez le renvoyer tel quel.",
    ),
}
ANSWERS = {
    "ok": ("Exercice réussi", "Toutes vos réponses sont bonnes. Bravo ! Le corrigé complet est ouvert plus bas."),
    "wrong_answer": ("Réponses à revoir", "Chaque question dit ce qui va et ce qui est à reprendre."),
    "syntax_error": ("Fichier illisible", "Ce fichier de réponses n’a pas pu être lu."),
    "invalid_output": ("Réponses incomplètes", "Une réponse au moins manque, ou n’a pas pu être lue."),
}
TIMINGS = {
    "load_ms": "chargement de votre fichier",
    "checks_ms": "vérifications",
    "diagnosis_ms": "recherche de l’erreur",
    "total_ms": "durée totale",
}


def view(verdict: Mapping[str, Any], figures: str, texts: Texts | None = None) -> VerdictView:
    """Lay out a verdict. `figures` is the address under which its figures are drawn.

    `course` is the exercise, where it is answered without code: the verdict's texts are then its Markdown.
    """
    outcome = str(verdict["outcome"])
    marked = texts is not None
    title, sentence = _words("answers" if marked else "code")[outcome]
    return VerdictView(
        outcome=outcome,
        title=title,
        sentence=sentence,
        tone=_tone(outcome, float(verdict["score"])),
        points="" if outcome == "internal_error" else points(verdict["points"]),
        common=_common_message(verdict["checks"]),
        checks=tuple(_check(one, figures, marked) for one in verdict["checks"]),
        diagnosis=_diagnosis(verdict["diagnosis"]),
        stdout=str(verdict["stdout"]),
        timings=tuple(_timing(name, value) for name, value in verdict["timings"].items()),
        seed=str(verdict["seed"]),
        version=str(verdict["exercise_version"]),
        texts=texts,
    )


def title_of(outcome: str | None, kind: str = "code") -> str:
    """The outcome in words; « en cours » while there is none."""
    return _words(kind)[outcome][0] if outcome else "En cours de correction"


def _words(kind: str) -> Mapping[str, tuple[str, str]]:
    return {**OUTCOMES, **ANSWERS} if kind == "answers" else OUTCOMES


def _tone(outcome: str, score: float) -> Tone:
    if outcome == "internal_error":
        return "ours"
    if outcome == "ok":
        return "good"
    return "partial" if score >= 0.5 else "bad"


def _common_message(checks: Sequence[Mapping[str, Any]]) -> str:
    """What every check says, when they all say the same: the file did not load, and once is enough."""
    messages = {str(check["message"]) for check in checks}
    return messages.pop() if len(messages) == 1 and len(checks) > 1 else ""


def _check(check: Mapping[str, Any], figures: str, marked: bool) -> CheckView:
    return CheckView(
        id=str(check["id"]),
        title=str(check["title"]),
        passed=bool(check["passed"]),
        points=points(check["points"]),
        max_points=points(check["max_points"]),
        message=str(check["message"]),
        hint=str(check["hint"] or ""),
        counterexample=_counterexample(check["counterexample"], shows_inputs=not marked),
        figure=_figure(check, figures) if check["figure"] else None,
    )


def _counterexample(found: Mapping[str, Any] | None, *, shows_inputs: bool) -> CounterexampleView | None:
    """Without code the data stand in the statement: they are not told again with each answer."""
    if found is None:
        return None
    given = found["inputs"] if shows_inputs else {}
    judged = found["expected"] is not None or found["got"] is not None
    return CounterexampleView(
        inputs=tuple((str(name), values.view(value)) for name, value in given.items()),
        expected=values.view(found["expected"]) if judged else None,
        got=values.view(found["got"], expected=found["expected"]) if judged else None,
        replay=values.replay(given),
    )


def _figure(check: Mapping[str, Any], figures: str) -> FigureView:
    address = f"{figures}/{check['figure']}.svg?theme="
    alt = f"Figure de la vérification « {check['title']} » : votre résultat superposé à la référence."
    return FigureView(address + "light", address + "dark", alt)


def _diagnosis(found: Mapping[str, Any] | None) -> DiagnosisView | None:
    if found is None:
        return None
    paragraphs = tuple(part.strip() for part in str(found["explanation"]).split("\n\n") if part.strip())
    return DiagnosisView(str(found["id"]), str(found["title"]), paragraphs)


def _timing(name: str, milliseconds: float) -> tuple[str, str]:
    return TIMINGS.get(name, name), f"{round(float(milliseconds))}\u00a0ms"
