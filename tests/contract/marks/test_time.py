"""On both databases: what is told before a send is what the mark says after it, whatever the rules become."""

from __future__ import annotations

import random
from dataclasses import replace
from datetime import timedelta
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from server.assignments import editing, exemption_service, repository, sitting_repository
from server.assignments.feedback import SittingStage, sitting_stage
from server.assignments.models import Assignment, LatePolicy, Mode
from server.assignments.rules import SendingWindow, TimingKind, is_sitting_running, rules_in_force
from server.assignments.schemas import ExemptionInput, ExemptionTarget
from server.base.errors import ServiceError
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.course import Course
from server.database import Database, utc_now
from server.marks.loading import load_gradebook
from tests.support.marks import POSES, Term

EXAMPLES = 25
HOUR = timedelta(hours=1)


def random_dates(draw: random.Random, *, is_test: bool) -> dict[str, Any]:
    now = utc_now()
    opens = now + draw.randint(-90, 1) * HOUR
    due = draw.choice([None, max(opens, now + draw.randint(-80, 80) * HOUR)])
    closes = draw.choice([None, max(due or opens, now + draw.randint(-40, 90) * HOUR)])
    late = draw.choice(list(LatePolicy)) if due else LatePolicy.accept
    return {
        "opens_at": opens,
        "due_at": due,
        "closes_at": closes,
        "late": late,
        "late_per_day": 2.0 if late is LatePolicy.penalty else None,
        "duration_minutes": draw.choice([None, 30, 600]) if is_test else None,
    }


@settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, 10**9), st.sampled_from(Mode))
def test_what_is_told_is_what_counts(database: Database, course: Course, seed: int, mode: Mode) -> None:
    draw, is_test = random.Random(seed), mode is Mode.test
    term = Term.begin(database)
    test = term.assignment(exercises={POSES: 1.0}, mode=mode, **random_dates(draw, is_test=is_test))
    ada = term.student("Ada", "Lovelace", groups=["TP1"])
    promised: list[float] = []
    for _ in range(draw.randint(2, 7)):
        action = draw.choice(["change", "grant", "revoke", "begin", "send", "send", "send"])
        with database.write() as db:
            school_class, one = db.get_one(SchoolClass, term.made.id), db.get_one(Assignment, test.id)
            try:
                with db.begin_nested():
                    if action == "change":
                        before = editing.load_editable_fields(db, one)
                        after = replace(before, **random_dates(draw, is_test=is_test))
                        editing.update_assignment(db, course, school_class, ada.id, one, after)
                    elif action == "grant":
                        dates = random_dates(draw, is_test=is_test)
                        fields = ExemptionInput(due_at=dates["due_at"], time_factor=draw.choice([None, 1.33]))
                        target = ExemptionTarget((ada.id,)) if draw.random() < 0.5 else ExemptionTarget(label="TP1")
                        members = classes.load_members(db, school_class.id)
                        exemption_service.grant_exemptions(db, school_class, ada.id, one, members, target, fields)
                    elif action == "revoke":
                        for exemption in repository.load_active_exemptions(db, one.id)[:1]:
                            exemption_service.revoke_exemption(db, school_class, ada.id, one, exemption)
            except ServiceError:
                continue  # refused in words
            now = utc_now()
            exemptions = repository.load_exemptions(db, [one.id]).get(one.id, ())
            rules = rules_in_force(one, exemptions, ada.id, ("TP1",))
            sitting = sitting_repository.load_sitting(db, one.id, ada.id)
            if action == "begin" and sitting_stage(one, rules, sitting, now) is SittingStage.may_begin:
                sitting_repository.insert_sitting_once(db, one.id, ada.id, now)
            may_send = not is_test or (sitting is not None and is_sitting_running(rules, sitting, now))
            timing = SendingWindow(rules, sitting).judge_timing(now)
        if action == "send" and may_send:
            term.send(ada, POSES, 20.0, now)
            points = timing.apply_late_penalty(20.0).points
            promised += [] if points is None else [points]
            assert (timing.kind is TimingKind.outside) is False
        with database.read() as db:
            gradebook = load_gradebook(db, course, db.get_one(SchoolClass, term.made.id), utc_now(), only=[ada.id])
        counted = gradebook.rows[0].marks[0].exercises[0].counted
        if promised:
            assert counted is not None
            assert counted.points >= max(promised)
