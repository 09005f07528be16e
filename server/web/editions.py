"""Which edition of a module somebody is shown: that of their class, else the last."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from server.base.errors import NotFound
from server.classes import repository
from server.course import Course, Module
from server.course.editions import parse_edition
from server.gradebook.schemas import ExerciseProgress
from server.web.schemas import EditionNote
from server.web.views import Reader

NEWER = "Une édition plus récente de ce module existe\u202f: {label}."
OURS = "Votre classe garde cette édition, jusqu’à ce que votre enseignant en change."
OTHER = "Votre classe travaille sur une autre édition de ce module\u202f: {label}."


def load_module_slugs_of_classes(reader: Reader) -> frozenset[str]:
    """The modules of one's classes, those that are archived left out."""
    if reader.account is None:
        return frozenset()
    joined = repository.load_joined_classes(reader.db, reader.account.id)
    return frozenset(seat.school_class.module for seat in joined if seat.school_class.archived_at is None)


def choose_visible_editions(reader: Reader, progress: Mapping[str, ExerciseProgress]) -> Sequence[Module]:
    """Of each module the edition of one's class, else the last, and those where one has begun; in the course's order.

    No query where each module has but one edition.
    """
    course = reader.course
    if len(course.latest) == len(course.modules):
        return course.latest
    own = load_module_slugs_of_classes(reader)
    families = {parse_edition(slug).family for slug in own if slug in course.modules}
    wanted = own | {module.slug for module in course.latest if parse_edition(module.slug).family not in families}
    begun = {
        exercise.partition("/")[0] for exercise, exercise_progress in progress.items() if exercise_progress.attempts
    }
    return [module for slug, module in course.modules.items() if slug in wanted | begun]


def build_edition_note(reader: Reader, module: Module) -> EditionNote | None:
    """Build the notice of a module that has other editions."""
    course = reader.course
    others = [edition for edition in course.editions(module.slug) if edition is not module]
    if not others:
        return None
    own = load_module_slugs_of_classes(reader)
    if module.slug in own:
        return EditionNote(OURS) if course.newer_edition(module.slug) else None
    for edition in others:
        if edition.slug in own:
            return EditionNote(OTHER.format(label=edition.label), f"/{edition.slug}")
    newer = course.newer_edition(module.slug)
    return EditionNote(NEWER.format(label=newer.label), f"/{newer.slug}") if newer else None


def list_editions_for_class_copy(course: Course, slug: str) -> tuple[Module, ...]:
    """The editions that a class of this one may be copied into: its own, where it is served, and those after it."""
    return tuple(later for later in course.editions(slug) if parse_edition(later.slug) >= parse_edition(slug))


def require_copy_edition(course: Course, current: str, chosen: str) -> str:
    """The module of a class's copy. Raises NotFound for one that is none of its later editions."""
    if chosen in {"", current} or any(
        edition.slug == chosen for edition in list_editions_for_class_copy(course, current)
    ):
        return chosen or current
    raise NotFound("Cette édition du module n’existe pas.")


def find_exercise_in_edition(course: Course, exercise: str, module: str) -> str | None:
    """The exercise of the same name in another edition, where it has one; in its own, served or not."""
    home, _, slug = exercise.partition("/")
    if home == module:
        return exercise
    found = f"{module}/{slug}"
    return found if found in course.exercises else None
