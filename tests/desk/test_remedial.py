"""From « Après la séance » to its doing: an exercise for these students, an assignment re-opened for them."""

from __future__ import annotations

import pytest

from server.assignments.models import Assignment, Exemption
from server.base.school_time import format_field
from server.classes.models import Membership
from server.desk.lesson.remedial import MAX_STUDENTS, remedial_href
from server.identity.models import Role
from tests.desk.test_assignments import DAY, NOW, OTHER, School, read
from tests.support.classes import new_class, person, seat
from tests.support.service import EXERCISE, Site


@pytest.fixture
def school(site: Site) -> School:
    martin, ada, bob = person(site, Role.teacher, "Mme Martin"), person(site, name="Ada"), person(site, name="Bob")
    made = new_class(site.database, martin.account)
    seat(site.database, made, ada.account)
    seat(site.database, made, bob.account)
    return School(site, made, martin.browser(site), ada, bob)


def test_an_exercise_is_given_to_the_students_of_a_line_alone(school: School) -> None:
    path = remedial_href(school.href, EXERCISE, [school.ada.id])
    page = school.martin.get(path).text
    assert f'<input type="checkbox" name="eleve" value="{school.ada.id}" checked> Ada' in page
    assert f'value="{school.bob.id}" checked' not in page
    form = {"action": "donner", "exercice": OTHER, "date": format_field(NOW + 7 * DAY), "eleve": str(school.ada.id)}
    for fault, words in (
        ({"date": ""}, "Donnez la date"),
        ({"date": format_field(NOW - DAY)}, "Cette date est passée"),
        ({"eleve": []}, "Cochez au moins un élève."),
        ({"exercice": "l20/rien"}, "n’est pas du module"),
    ):
        refused = school.martin.post(f"{school.href}/reprise", data=form | fault)
        assert refused.status_code == 422, words
        assert words in refused.text
    assert not school.stored(Assignment)
    for _ in range(2):
        assert school.martin.post(f"{school.href}/reprise", data=form).status_code == 303
    labels = {row.account_id: row.groups for row in school.stored(Membership)}
    assert len(labels[school.ada.id]) == 1, "the same students are one group, however often"
    assert not labels[school.bob.id]
    assert "Reprise :" in read(school.ada.browser(school.site), school.href)
    assert "Reprise :" not in read(school.bob.browser(school.site), school.href)


def test_an_assignment_is_reopened_for_some_and_stays_closed_for_the_others(school: School) -> None:
    dates = {"ouvre": NOW - 9 * DAY, "rendre": NOW - 3 * DAY, "ferme": NOW - 2 * DAY}
    href = school.give(**{name: format_field(date) for name, date in dates.items()})
    aid, until = href.rpartition("/")[2], NOW + 4 * DAY
    assert f'<option value="{aid}">' in school.martin.get(f"{school.href}/reprise").text
    form = {"action": "rouvrir", "devoir": aid, "date": format_field(until), "eleve": str(school.ada.id)}
    assert school.martin.post(f"{school.href}/reprise", data=form).status_code == 303
    (granted,) = school.stored(Exemption)
    assert (granted.account_id, granted.due_at, granted.closes_at) == (school.ada.id, until, until)
    assert "▶ ouvert" in read(school.ada.browser(school.site), school.href)
    assert "■ fermé" in read(school.bob.browser(school.site), school.href)
    with school.site.database.write() as db:
        db.get_one(Assignment, granted.assignment_id).groups = ("TP9",)
    refused = school.martin.post(f"{school.href}/reprise", data=form)
    assert refused.status_code == 422
    assert "Ce devoir n’est pas donné à Ada" in refused.text


def test_a_line_with_more_students_than_an_address_holds_has_no_link(school: School) -> None:
    assert remedial_href("", EXERCISE, []) == ""
    assert remedial_href("", EXERCISE, [school.ada.id] * (MAX_STUDENTS + 1)) == ""
