"""French messages of a trace: its omissions and its end."""

from __future__ import annotations

from collections.abc import Sequence

from server.sandbox.child import tracer

THIN = "\u202f"


def _format_count(number: int) -> str:
    return f"{number:,}".replace(",", THIN)


_OMISSION_MESSAGES = {
    tracer.STEPS_OVER: f"Seuls les {_format_count(tracer.STEPS)} premiers pas sont montrés : "
    "la suite n’a pas été suivie.",
    tracer.DEPTH_OVER: f"Les appels imbriqués sur plus de {tracer.DEPTH} niveaux n’ont pas été suivis.",
    tracer.NODES_OVER: "Les variables ont trop de valeurs pour être toutes montrées : la suite n’a pas été suivie.",
    tracer.TIME_OVER: "Regarder les variables à chaque ligne prenait trop de temps : la suite n’a pas été suivie.",
    tracer.VARIABLES_OVER: f"Seules {tracer.VARIABLES} variables d’une même fonction sont montrées.",
    tracer.NOT_OURS: "Les fonctions de mes_fonctions se sont exécutées sans être suivies.",
    tracer.LOST: "Votre programme a lui-même changé ce qui permet de le suivre : la suite manque.",
}  # fmt: skip
#: After these, the program runs on and its end alone is known.
_STOPPING_REASONS = frozenset({tracer.STEPS_OVER, tracer.NODES_OVER, tracer.TIME_OVER, tracer.LOST})
PRINTED_TOO_MUCH = "Ce qui est affiché est trop long : la fin manque."
CUT = "Suivi interrompu"
NOT_ENDED = "Votre programme n’avait pas fini quand le temps du suivi a été écoulé : le reste n’est pas connu."
NOT_FOUND = "Cas introuvable"
NOT_THE_SAME = (
    "Ce cas n’a pas pu être retrouvé à l’identique : l’exercice a changé depuis, ou votre programme ne répond pas deux "
    "fois la même chose."
)

FORGED = (
    "Votre programme a lui-même écrit sur le canal par lequel il est suivi : on ne peut pas montrer ce qu’il a fait."
)
OWN_EXCEPTION = "Votre programme s’arrête sur votre exception « {name} », que rien ne rattrape."
ANSWERED_OTHERWISE = (
    "Appelée seule, la fonction n’a pas renvoyé la même chose que pendant la correction : elle se souvient d’appels "
    "précédents, ou tire au hasard."
)


def list_omission_messages(reasons: Sequence[str], *, truncated: bool) -> list[str]:
    return [*(_OMISSION_MESSAGES[reason] for reason in reasons), *([PRINTED_TOO_MUCH] if truncated else [])]


def was_tracing_stopped(reasons: Sequence[str]) -> bool:
    """Whether tracing stopped before the program's end."""
    return not _STOPPING_REASONS.isdisjoint(reasons)
