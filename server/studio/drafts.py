"""A draft: all that an author has typed, whether it makes an exercise yet or not."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

#: Bounds of a draft: characters in all, checks, cases of one, mistakes, hints.
MAX_CHARACTERS, MAX_CHECKS, MAX_CASES, MAX_MISTAKES, HINTS = 150_000, 6, 40, 12, 3
#: Keys of a check in a declaration, with the fields in which they are typed: texts, numbers, flags; then choices, with
#: the one that is not written.
CHECK_TEXTS = {"indice": "hint", "tirages": "draws", "appel": "call"}
CHECK_NUMBERS = {"points": "points", "combien": "count", "tolerance": "tolerance"}
CHECK_FLAGS = {"absolue": "absolute", "types_stricts": "strict"}
CHECK_CHOICES = {"ordre": ("order", "oui"), "regarder": ("watched", "valeur")}
EXAMPLES_TITLE = "Les exemples de l’énoncé"
#: The title of the first check where the statement does not show all its cases.
MORE_EXAMPLES_TITLE = "Des exemples qui ne sont pas tous dans l’énoncé"
#: The fields of a check as a form says them, beside its cases.
CHECK_LABELS = {
    "title": "Titre", "points": "Points", "hint": "Indice", "draws": "Variables tirées", "call": "Appel tiré",
    "count": "Nombre de tirages", "conditions": "Conditions", "tolerance": "Écart permis", "absolute": "Écart absolu",
    "order": "Ordre des éléments", "strict": "Types stricts", "ignores_spaces": "Espaces et majuscules ne comptent pas",
    "watched": "Ce qui est comparé", "lines": "Saisie au clavier", "files": "Fichiers",
}  # fmt: skip


@dataclass(frozen=True)
class CaseDraft:
    """A call, and what it must give, if the author says it."""

    call: str = ""
    expected: str = ""

    @property
    def is_empty(self) -> bool:
        return not (self.call.strip() or self.expected.strip())


@dataclass(frozen=True)
class CheckDraft:
    """A check as it is typed; `files` are « === name » lines, each followed by the text of the file."""

    title: str = ""
    points: str = ""
    hint: str = ""
    cases: tuple[CaseDraft, ...] = ()
    draws: str = ""
    call: str = ""
    count: str = ""
    conditions: str = ""
    tolerance: str = ""
    absolute: bool = False
    order: str = "oui"
    strict: bool = False
    ignores_spaces: bool = False
    watched: str = "valeur"
    lines: str = ""
    files: str = ""

    @property
    def is_empty(self) -> bool:
        return not any(text.strip() for text in (self.title, self.draws, self.call)) and not self.nonempty_cases

    @property
    def nonempty_cases(self) -> tuple[CaseDraft, ...]:
        return tuple(case for case in self.cases if not case.is_empty)

    @property
    def described_text(self) -> str:
        """The check in words, a line for each case and each field that its author has changed."""
        cases = [f"{case.call} → {case.expected or '(celui de la solution)'}" for case in self.nonempty_cases]
        usual = CheckDraft()
        changed = [
            (label, getattr(self, name))
            for name, label in CHECK_LABELS.items()
            if getattr(self, name) != getattr(usual, name)
        ]
        return "\n".join(cases + [f"{label} : {'oui' if value is True else value}" for label, value in changed])


@dataclass(frozen=True)
class MistakeDraft:
    """A known mistake as it is typed."""

    title: str = ""
    explanation: str = ""
    question: str = ""
    program: str = ""

    @property
    def is_empty(self) -> bool:
        return not any(text.strip() for text in asdict(self).values())


@dataclass(frozen=True)
class ExerciseDraft:
    """An exercise as it is typed. `reasons` say why a change of the solution, by its digest, need not be refused."""

    title: str = ""
    summary: str = ""
    level: str = ""
    themes: str = ""
    statement: str = ""
    functions: str = ""
    solution: str = ""
    starter: str = ""
    forbidden: str = ""
    required: str = ""
    hints: tuple[str, ...] = ("",) * HINTS
    checks: tuple[CheckDraft, ...] = (CheckDraft(),)
    mistakes: tuple[MistakeDraft, ...] = ()
    reasons: Mapping[str, str] = field(default_factory=dict)

    def to_data(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> ExerciseDraft:
        """Return the draft that `to_data` gave, whatever JSON has made of its tuples."""
        checks = tuple(
            CheckDraft(**{**each, "cases": tuple(CaseDraft(**case) for case in each["cases"])})
            for each in data["checks"]
        )
        mistakes = tuple(MistakeDraft(**each) for each in data["mistakes"])
        return cls(**{**data, "checks": checks, "mistakes": mistakes, "hints": tuple(data["hints"])})

    def without_empty_parts(self) -> ExerciseDraft:
        """Return the draft without rows in which nothing stands; the first check stays."""
        checks = [replace(check, cases=check.nonempty_cases) for check in self.checks]
        kept = [checks[0], *(check for check in checks[1:] if not check.is_empty)] if checks else [CheckDraft()]
        return replace(self, checks=tuple(kept), mistakes=tuple(it for it in self.mistakes if not it.is_empty))

    @property
    def texts_by_label(self) -> dict[str, str]:
        """The draft by the labels of its fields, to compare two versions of it."""
        checks = {f"Vérification {number}": check.described_text for number, check in enumerate(self.checks, 1)}
        mistakes = {
            f"Erreur {number}": "\n".join(asdict(mistake).values()) for number, mistake in enumerate(self.mistakes, 1)
        }
        single = {
            "Titre": self.title, "Résumé": self.summary, "Niveau": self.level, "Thèmes": self.themes,
            "Énoncé": self.statement, "Fonctions": self.functions, "Solution": self.solution, "Départ": self.starter,
            "Interdits": self.forbidden, "Demandés": self.required, "Indices": "\n".join(self.hints),
            "Raisons": "\n".join(f"{name} : {reason}" for name, reason in sorted(self.reasons.items())),
        }  # fmt: skip
        return {label: text.replace("\r\n", "\n").strip() for label, text in (single | checks | mistakes).items()}

    @property
    def digest(self) -> str:
        text = json.dumps(self.to_data(), ensure_ascii=False, sort_keys=True)
        return hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()

    @property
    def character_count(self) -> int:
        return len(json.dumps(self.to_data(), ensure_ascii=False))


def program_digest(program: str) -> str:
    """Return the short digest by which a changed solution is known."""
    return hashlib.sha256(program.encode("utf-8", "replace")).hexdigest()[:12]
