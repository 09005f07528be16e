"""Finding an exercise by its id, or by the last part of it."""

from __future__ import annotations

from difflib import get_close_matches

from .connection import ServerConnection
from .errors import ClientError


def find_exercise_id(connection: ServerConnection, name: str) -> str:
    """Return the id of an exercise, of which the last part will do. Raises ClientError with near names."""
    ids = [str(exercise["id"]) for exercise in connection.list_exercises()]
    by_slug = [exercise for exercise in ids if exercise == name or exercise.rpartition("/")[2] == name]
    if len(by_slug) == 1:
        return by_slug[0]
    slugs = {exercise.rpartition("/")[2]: exercise for exercise in ids}
    near = by_slug or [
        *get_close_matches(name, ids, 3, 0.6),
        *(slugs[slug] for slug in get_close_matches(name, list(slugs), 3, 0.6)),
    ]
    meant = f" Vouliez-vous dire {' ou '.join(dict.fromkeys(near))} ?" if near else " « list » les donne tous."
    raise ClientError(f"aucun exercice ne s’appelle « {name} ».{meant}")
