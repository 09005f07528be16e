"""The rights, and the table of the roles that have them."""

from collections.abc import Mapping
from enum import StrEnum

from server.classes.models import ClassRole

STUDENT, ASSISTANT, TEACHER = ClassRole.student, ClassRole.assistant, ClassRole.teacher


class Right(StrEnum):
    """Rights in a class or on the server; the values name them in refusals."""

    see_class = "voir la classe"
    leave_class = "quitter la classe"
    hand_in_together = "rendre à plusieurs les devoirs de la classe"
    sit_tests = "composer dans les contrôles de la classe"
    answer_questions = "répondre aux questions de la classe"
    see_students = "voir les élèves de la classe"
    read_work = "lire les essais des élèves de la classe"
    comment = "commenter les essais des élèves de la classe"
    run_lessons = "mener les séances de la classe"
    see_code = "voir le code de la classe"
    manage_roster = "tenir la liste de la classe"
    erase_students = "effacer les élèves de la classe"
    hand_out_passwords = "remettre les mots de passe de la classe"
    open_solutions = "ouvrir les corrigés à la classe"
    compare_codes = "comparer les copies de la classe"
    read_marks = "lire les notes de la classe"
    change_marks = "changer les notes de la classe"
    read_audit_log = "lire le journal de la classe"
    release_feedback = "publier les résultats des contrôles de la classe"
    see_assignments = "voir les devoirs de la classe"
    manage_assignments = "donner les devoirs de la classe"
    configure_class = "régler la classe"
    regrade = "recorriger les essais de la classe"
    name_behaviours = "nommer une erreur pour la classe"
    create_class = "créer une classe"
    write_exercises = "écrire des exercices"
    open_solutions_to_all = "ouvrir les corrigés à tous"


#: Rights of the active members of a class by role; an administrator has all but `MEMBER_ONLY_RIGHTS` in every class.
ROLES_BY_RIGHT: Mapping[Right, frozenset[ClassRole]] = {
    Right.see_class: frozenset({STUDENT, ASSISTANT, TEACHER}),
    Right.leave_class: frozenset({STUDENT, ASSISTANT, TEACHER}),
    Right.hand_in_together: frozenset({STUDENT}),
    Right.sit_tests: frozenset({STUDENT}),
    Right.answer_questions: frozenset({STUDENT}),
    Right.see_students: frozenset({ASSISTANT, TEACHER}),
    Right.read_work: frozenset({ASSISTANT, TEACHER}),
    Right.comment: frozenset({ASSISTANT, TEACHER}),
    Right.run_lessons: frozenset({ASSISTANT, TEACHER}),
    Right.see_code: frozenset({ASSISTANT, TEACHER}),
    Right.manage_roster: frozenset({TEACHER}),
    Right.erase_students: frozenset({TEACHER}),
    Right.hand_out_passwords: frozenset({TEACHER}),
    Right.open_solutions: frozenset({TEACHER}),
    Right.compare_codes: frozenset({TEACHER}),
    Right.read_marks: frozenset({ASSISTANT, TEACHER}),
    Right.change_marks: frozenset({TEACHER}),
    Right.read_audit_log: frozenset({TEACHER}),
    Right.release_feedback: frozenset({TEACHER}),
    Right.see_assignments: frozenset({STUDENT, ASSISTANT, TEACHER}),
    Right.manage_assignments: frozenset({TEACHER}),
    Right.configure_class: frozenset({TEACHER}),
    Right.regrade: frozenset({TEACHER}),
    Right.name_behaviours: frozenset({TEACHER}),
}

#: Rights of members alone, by their own role.
MEMBER_ONLY_RIGHTS = frozenset({Right.leave_class, Right.hand_in_together, Right.sit_tests, Right.answer_questions})

#: Rights of accounts that ask to join: they see that the class exists, and may withdraw.
PENDING_RIGHTS = frozenset({Right.see_class, Right.leave_class})
