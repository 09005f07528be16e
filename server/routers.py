"""All routes of the web application, in the order in which they are asked whether an address is theirs."""

from server.api.guide import router as guide_router
from server.api.routes import router as api_router
from server.cells.routes import router as cells_router
from server.client.routes import router as client_router
from server.desk.assignments.exemption_routes import router as exemptions_router
from server.desk.assignments.routes import router as assignments_router
from server.desk.assignments.team_pages import router as teams_router
from server.desk.board.routes import router as board_router
from server.desk.groups.routes import router as groups_router
from server.desk.guide.routes import router as teachers_guide_router
from server.desk.lesson.mail_routes import router as lesson_mail_router
from server.desk.lesson.remedial import router as remedial_router
from server.desk.lesson.routes import router as lesson_router
from server.desk.likeness.routes import router as likeness_router
from server.desk.marks.column_routes import router as columns_router
from server.desk.marks.journal import router as journal_router
from server.desk.marks.routes import router as marks_router
from server.desk.objectives.routes import router as objectives_router
from server.desk.own.routes import router as own_router
from server.desk.people.erasing import router as erasing_router
from server.desk.people.group_pages import router as class_groups_router
from server.desk.people.management import router as keeping_router
from server.desk.people.routes import router as classes_router
from server.desk.polls.routes import router as polls_router
from server.desk.regrades.routes import router as regrades_router
from server.desk.rubrics.routes import router as rubrics_router
from server.desk.school.roster import router as school_list_router
from server.desk.school.routes import router as school_router
from server.desk.sitting.routes import router as sitting_router
from server.desk.studio.routes import router as studio_router
from server.desk.talk.routes import router as talking_router
from server.desk.talk.students import router as students_router
from server.desk.warmup.routes import router as warm_up_router
from server.health.routes import router as health_router
from server.offline.routes import router as offline_router
from server.pages.accessibility import router as accessibility_router
from server.pages.accounts import router as accounts_router
from server.pages.administration import router as administration_router
from server.pages.after_success import router as after_success_router
from server.pages.calendar import router as calendar_router
from server.pages.comments import router as comments_router
from server.pages.drawn import router as drawn_router
from server.pages.hunts import router as hunts_router
from server.pages.notebook import router as notebook_router
from server.pages.objectives import router as own_objectives_router
from server.pages.own_run import router as own_run_router
from server.pages.person import router as person_router
from server.pages.routes import router as pages_router
from server.pages.school.content import router as content_router
from server.pages.school.courses import router as courses_router
from server.pages.school.entries import router as entries_router
from server.pages.school.keys import router as keys_router
from server.pages.school.launches import router as launches_router
from server.pages.school.lti_forms import router as lti_forms_router
from server.pages.school.platforms import router as platforms_router
from server.pages.school.registration import link_router
from server.pages.school.registration import router as registration_router
from server.pages.school.rules import router as rules_router
from server.pages.school.server_forms import router as server_forms_router
from server.pages.two_minutes import router as two_minutes_router
from server.reading.routes import router as reading_router
from server.replays.routes import router as replays_router
from server.steps.routes import router as steps_router

#: Routers whose requests carry their own proof of identity, or give one: tokens, log-in forms.
UNNAMED_ROUTERS = (api_router, health_router, guide_router, accounts_router, launches_router, registration_router)

#: Each is asked in turn whether an address is one of its own: what is asked for most comes first.
ROUTERS = (
    api_router,
    health_router,
    pages_router,
    reading_router,
    drawn_router,
    guide_router,
    accounts_router,
    person_router,
    after_success_router,
    notebook_router,
    own_objectives_router,
    hunts_router,
    own_run_router,
    two_minutes_router,
    administration_router,
    calendar_router,
    accessibility_router,
    platforms_router,
    lti_forms_router,
    server_forms_router,
    rules_router,
    entries_router,
    keys_router,
    launches_router,
    registration_router,
    link_router,
    courses_router,
    content_router,
    comments_router,
    board_router,
    lesson_router,
    warm_up_router,
    remedial_router,
    lesson_mail_router,
    objectives_router,  # before those of students, whose paths take any name
    classes_router,
    class_groups_router,
    erasing_router,
    keeping_router,
    likeness_router,
    students_router,
    talking_router,
    columns_router,  # before those of marks, whose paths take any name
    marks_router,
    journal_router,
    polls_router,
    school_router,
    school_list_router,
    regrades_router,
    groups_router,
    sitting_router,
    rubrics_router,
    assignments_router,
    exemptions_router,
    teams_router,
    own_router,
    studio_router,
    teachers_guide_router,
    offline_router,
    client_router,
    cells_router,
    steps_router,
    replays_router,
)
