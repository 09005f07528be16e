"""Make, rename and dissolve the groups of a class: labels of its students.

Every function works inside the caller's transaction, on a class whose list the caller may change (`server.rights`).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from random import Random
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository
from server.assignments.members import recording_member_changes
from server.base.errors import Invalid, InvalidFields, NotFound
from server.classes import repository as classes
from server.classes.folding import normalise_name
from server.classes.models import SchoolClass
from server.classes.roster_line import MAX_GROUPS, parse_group_labels
from server.classes.schemas import Member
from server.classes.service import require_not_archived

MAX_LINES, MIN_DEALT, MAX_DEALT = 500, 2, 30
#: Letters of a line beyond which it is no name, login or address of anybody: it is not folded.
MAX_LINE_LENGTH = 400
NO_GROUP = "Cette classe n’a pas ce groupe."
ONE_NAME = "Donnez au groupe un seul nom, sans virgule ni point-virgule."
TAKEN = "Il y a déjà un groupe « {label} » : donnez un autre nom, ou ajoutez-lui des élèves sur la page « Élèves »."
NOBODY = "Écrivez au moins un nom d’élève, un par ligne."
UNKNOWN_LINES = "Ces lignes ne désignent aucun élève de la classe : {lines}."
SEVERAL = "Plusieurs élèves s’appellent ainsi ; écrivez leur identifiant : {lines}."
FULL = "{name} est déjà dans {count} groupes, le plus qu’un élève puisse en avoir."
HOW_MANY = f"Indiquez de {MIN_DEALT} à {MAX_DEALT} groupes."
TOO_FEW = "Il faut au moins un élève par groupe : la classe en a {count}."
IN_USE = "Le groupe « {label} » sert encore : {uses}. Changez d’abord à qui c’est donné."


@dataclass(frozen=True)
class GroupUsage:
    """What depends on a group: titles of the assignments given to it, and of those with an exemption for it."""

    assignments: tuple[str, ...] = ()
    exemptions: tuple[str, ...] = ()


def load_group_usage(db: Session, school_class: SchoolClass) -> Mapping[str, GroupUsage]:
    """Return what depends on each group of a class."""
    given, exempted = defaultdict(list), defaultdict(list)
    assignments = repository.load_class_assignments(db, school_class.id)
    exemptions = repository.load_exemptions(db, [assignment.id for assignment in assignments])
    for assignment in assignments:
        for label in assignment.groups:
            given[label].append(assignment.title)
        active = (each for each in exemptions.get(assignment.id, ()) if each.revoked_at is None)
        for label in {each.label for each in active if each.label is not None}:
            exempted[label].append(assignment.title)
    labels = given.keys() | exempted.keys()
    return {label: GroupUsage(tuple(given.get(label, ())), tuple(exempted.get(label, ()))) for label in labels}


def find_named_students(members: Sequence[Member], text: str) -> Sequence[UUID]:
    """Return the active students whom the lines of a text name: by name in either order, by login or by e-mail.

    Raises InvalidFields for `names`, with every line that names nobody, or several.
    """
    by_key: dict[str, set[UUID]] = defaultdict(set)
    for member in members:
        if member.is_active_student:
            for key in _matching_keys(member):
                by_key[key].add(member.id)
    lines = [line.strip() for line in text.splitlines() if line.strip()][:MAX_LINES]
    if not lines:
        raise InvalidFields({"names": NOBODY})
    matches = [(line, by_key.get(_fold_name(line), set()) if len(line) <= MAX_LINE_LENGTH else set()) for line in lines]
    for problem, wrong in (
        (UNKNOWN_LINES, [line for line, students in matches if not students]),
        (SEVERAL, [line for line, students in matches if len(students) > 1]),
    ):
        if wrong:
            raise InvalidFields({"names": problem.format(lines=", ".join(f"« {line[:60]} »" for line in wrong[:10]))})
    return list(dict.fromkeys(student for _, students in matches for student in students))


def _matching_keys(member: Member) -> Collection[str]:
    names = (member.name, member.plain_name, member.account.name)
    handles = (member.account.login or "", member.membership.email)
    return {_fold_name(text) for text in (*names, *handles) if text}


def _fold_name(text: str) -> str:
    return " ".join(sorted(normalise_name(text).split()))


def create_group(db: Session, school_class: SchoolClass, by: UUID, name: str, students: Collection[UUID]) -> str:
    """Put students into a new group, and return its label. Raises Conflict or InvalidFields."""
    label = _require_new_label(name, load_taken_group_names(db, school_class))
    _add_students_to_groups(db, school_class, by, {label: students})
    return label


def create_random_groups(
    db: Session,
    school_class: SchoolClass,
    by: UUID,
    name: str,
    count: int,
    students: Sequence[UUID],
    random: Random,
) -> Sequence[str]:
    """Deal students at random into new groups of equal size, within one: « TP 1 », « TP 2 »… Return their labels.

    Raises Conflict or InvalidFields.
    """
    if not MIN_DEALT <= count <= MAX_DEALT:
        raise InvalidFields({"count": HOW_MANY})
    if len(students) < count:
        raise InvalidFields({"count": TOO_FEW.format(count=len(students))})
    taken = load_taken_group_names(db, school_class)
    labels = [_require_new_label(f"{name} {number}", taken) for number in range(1, count + 1)]
    shuffled = random.sample(list(students), len(students))
    _add_students_to_groups(db, school_class, by, {label: shuffled[index::count] for index, label in enumerate(labels)})
    return labels


def parse_group_label(name: str) -> str:
    """Return the label that a text writes. Raises InvalidFields for `name`."""
    try:
        labels = parse_group_labels(name)
    except Invalid as refused:
        raise InvalidFields({"name": refused.detail[:1].upper() + refused.detail[1:]}) from None
    if len(labels) != 1:
        raise InvalidFields({"name": ONE_NAME})
    return labels[0]


def load_taken_group_names(db: Session, school_class: SchoolClass) -> frozenset[str]:
    """Load the names of the groups of a class, and of those that something still depends on, as `normalise_name` folds
    them."""
    labels = (
        _labels_of_active_students(classes.load_members(db, school_class.id))
        | load_group_usage(db, school_class).keys()
    )
    return frozenset(map(normalise_name, labels))


def _require_new_label(name: str, taken: Collection[str]) -> str:
    """Return the label of a group to make; `taken` are folded names. Raises InvalidFields."""
    label = parse_group_label(name)
    if normalise_name(label) in taken:
        raise InvalidFields({"name": TAKEN.format(label=label)})
    return label


def _labels_of_active_students(members: Sequence[Member]) -> frozenset[str]:
    return frozenset(label for member in members if member.is_active_student for label in member.groups)


def _add_students_to_groups(
    db: Session, school_class: SchoolClass, by: UUID, groups: Mapping[str, Collection[UUID]]
) -> None:
    require_not_archived(school_class)
    classes.lock_class(db, school_class.id)
    members = {member.id: member for member in classes.load_members(db, school_class.id)}
    with recording_member_changes(db, school_class.id, by):
        for label, students in groups.items():
            for student in students:
                member = members[student]
                if len(member.groups) >= MAX_GROUPS:
                    raise InvalidFields({"names": FULL.format(name=member.name, count=MAX_GROUPS)})
                member.membership.groups = [*member.groups, label]


def rename_group(db: Session, school_class: SchoolClass, by: UUID, label: str, name: str) -> str:
    """Rename a group, wherever it is named; return its label. Raises NotFound, Conflict or InvalidFields."""
    require_not_archived(school_class)
    classes.lock_class(db, school_class.id)
    members = classes.load_members(db, school_class.id)
    if label not in _labels_of_active_students(members):
        raise NotFound(NO_GROUP)
    new = label if name.strip() == label else _require_new_label(name, load_taken_group_names(db, school_class))
    with recording_member_changes(db, school_class.id, by):
        for member in members:
            if label in member.groups:
                member.membership.groups = _replace_label(member.groups, label, new)
        repository.rename_group_label(db, school_class.id, label, new)
    return new


def _replace_label(labels: Collection[str], old: str, new: str) -> list[str]:
    return [new if label == old else label for label in labels]


def delete_group(db: Session, school_class: SchoolClass, by: UUID, label: str) -> None:
    """Take all students out of a group. Raises NotFound, Conflict for an archived class, or InvalidFields where an
    assignment or an exemption is given to the group."""
    require_not_archived(school_class)
    classes.lock_class(db, school_class.id)
    members = [member for member in classes.load_members(db, school_class.id) if label in member.groups]
    if not members:
        raise NotFound(NO_GROUP)
    use = load_group_usage(db, school_class).get(label)
    if use is not None:
        words = [f"devoir « {title} »" for title in use.assignments]
        words += [f"aménagement du devoir « {title} »" for title in use.exemptions]
        raise InvalidFields({"name": IN_USE.format(label=label, uses=", ".join(words))})
    with recording_member_changes(db, school_class.id, by):
        for member in members:
            member.membership.groups = [own for own in member.groups if own != label]
