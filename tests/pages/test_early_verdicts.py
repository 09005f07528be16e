"""The mark does not wait for the reason: checks are shown while the name of the mistake is still sought."""

from __future__ import annotations

import time
from typing import Any

from graders.core.code.grading import CodeGrader
from graders.core.contract.findings import Judgement
from graders.core.contract.local import LOCAL
from graders.core.contract.protocol import WhileNaming, no_early_verdict
from graders.core.contract.verdict import Verdict
from server.base.app_services import get_service
from server.base.settings import Settings
from server.course import Course
from server.gradebook import early_verdicts
from server.grading.early_verdicts import EarlyVerdictStore
from server.grading.grading_task import GradingInput, GradingTask
from server.queue.interfaces import NullNotifier
from server.queue.service import TableQueue
from server.queue.worker import Worker
from server.submissions.service import GRADE
from tests.support.quick import the_course
from tests.support.small_site import SmallSite, verdict

NAMED = {"id": "oubli", "title": "Rien n’est doublé", "explanation": "Un.\n\nDeux ?"}


def test_checks_are_shown_while_the_mistake_is_sought(small_site: SmallSite) -> None:
    href = small_site.submit("def double(x):\n    return x\n")
    shown: list[str] = []

    def grade(sent: GradingInput) -> Judgement:
        early = EarlyVerdictStore(small_site.database, NullNotifier(), patience=0.0).show_verdict_while_naming(
            sent.submission_id
        )
        with early(Judgement(Verdict.from_json(verdict()))):
            while not _is_early(small_site, sent):
                time.sleep(0.001)
            shown.append(small_site.get(f"{href}/verdict"))
        return Judgement(Verdict.from_json(verdict(diagnosis=NAMED)))

    app: Any = small_site.client.app
    tasks = {GRADE: GradingTask(get_service(app, Course), grade)}
    assert Worker(small_site.database, TableQueue(NullNotifier()), get_service(app, Settings), tasks).run_one()
    assert 'data-status="running"' in shown[0]
    assert '<p class="score">0<' in shown[0]
    assert "On attend 4." in shown[0]
    assert "la cause est encore cherchée" in shown[0]
    assert "Rien n’est doublé" not in shown[0]
    page = small_site.get(f"{href}/verdict")
    assert "Rien n’est doublé" in page
    assert "encore cherchée" not in page
    with small_site.database.read() as db:
        assert not early_verdicts.has_early_verdict(db, _identity(href))


def _identity(href: str) -> Any:
    from uuid import UUID

    return UUID(href.rpartition("/")[2])


def _is_early(site: SmallSite, sent: GradingInput) -> bool:
    with site.database.read() as db:
        return early_verdicts.has_early_verdict(db, sent.submission_id)


def test_a_name_that_is_found_at_once_stores_nothing(small_site: SmallSite) -> None:
    identity = _identity(small_site.submit("x = 1"))
    with EarlyVerdictStore(small_site.database, NullNotifier(), patience=60.0).show_verdict_while_naming(identity)(
        Judgement(Verdict.from_json(verdict()))
    ):
        pass
    with small_site.database.read() as db:
        assert not early_verdicts.has_early_verdict(db, identity)


def test_only_what_a_name_is_sought_for_comes_early() -> None:
    grader = the_course().exercises["l20/odometrie"].grader
    assert isinstance(grader, CodeGrader)
    early: list[Verdict] = []

    def record(judgement: Judgement) -> Any:
        early.append(judgement.verdict)
        return no_early_verdict(judgement)

    while_naming: WhileNaming = record
    for source in (grader.solution, "def odometrie(pose, ds_g, ds_d, L):\n    return pose\n"):
        final = grader.grade(source.encode(), LOCAL, seed=1, version="v", while_naming=while_naming).verdict
    assert len(early) == 1
    assert early[0].points == final.points
    assert [check.to_json() for check in early[0].checks] == [check.to_json() for check in final.checks]
