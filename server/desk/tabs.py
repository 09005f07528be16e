"""The table of a class's tabs."""

from __future__ import annotations

from collections.abc import Callable

from server.desk.schemas import ClassTab
from server.rights.models import Right

#: Required right, label and path of each tab.
STAFF_TABS: tuple[tuple[Right, str, str], ...] = (
    (Right.read_work, "Séance", "/seance"),
    (Right.read_work, "Tableau", "/tableau"),
    (Right.read_work, "Objectifs", "/objectifs"),
    (Right.see_students, "Devoirs", "/devoirs"),
    (Right.read_marks, "Carnet", "/carnet"),
    (Right.read_work, "Questions", "/questions"),
    (Right.read_work, "Prévisions", "/previsions"),
    (Right.see_students, "Élèves", "/eleves"),
    (Right.read_audit_log, "Journal", "/journal"),
    (Right.regrade, "Recorriger", "/recalculs"),
    (Right.configure_class, "Réglages", "/reglages"),
)


def visible_tabs(href: str, may: Callable[[Right], bool], here: str) -> tuple[ClassTab, ...]:
    """Return the tabs that the reader may use; `here` is the current path within the class. Students get none."""
    if not may(Right.see_students):
        return ()
    return tuple(ClassTab(label, href + path, path == here) for right, label, path in STAFF_TABS if may(right))
