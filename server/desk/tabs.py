"""The pages of a class that its tabs lead to: the one table of them."""

from __future__ import annotations

from collections.abc import Callable

from server.desk.schemas import Tab
from server.rights.models import Right

#: For who sees the class as its staff do, and for who learns there: what it takes, what the tab says, where it leads.
STAFF: tuple[tuple[Right, str, str], ...] = (
    (Right.read_work, "Tableau", ""),
    (Right.see_students, "Devoirs", "/devoirs"),
    (Right.read_marks, "Carnet", "/carnet"),
    (Right.read_work, "Questions", "/questions"),
    (Right.read_work, "Prévisions", "/previsions"),
    (Right.see_students, "Élèves", "/eleves"),
    (Right.read_audit_log, "Journal", "/journal"),
    (Right.regrade, "Recorrections", "/recalculs"),
    (Right.configure_class, "Réglages", "/reglages"),
)


def tabs(href: str, may: Callable[[Right], bool], here: str) -> tuple[Tab, ...]:
    """Those of who may use them; `here` is the path of the page within the class. A student's page stands alone."""
    if not may(Right.see_students):
        return ()
    return tuple(Tab(label, href + path, path == here) for right, label, path in STAFF if may(right))
