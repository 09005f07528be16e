"""The table in `server/rights/README.md` has every route of the application, and tells what each does."""

from __future__ import annotations

import gzip
import re
from dataclasses import replace
from datetime import timedelta
from typing import Any
from uuid import UUID, uuid4

import pytest
from fastapi import FastAPI
from fastapi.routing import iter_route_contexts
from sqlalchemy.orm import Session

from graders.core.code.stored_answers import serialize_answers
from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import Diagnosis
from server.assignments.models import AssignedExercise, Assignment, Exemption, Mode
from server.base.app_services import get_service
from server.base.files import ROOT
from server.base.http import SESSION_COOKIE
from server.behaviour.models import BehaviourGroup, BehaviourName, Fingerprint
from server.board.live import LiveClassViews
from server.calendars import service as calendars
from server.classes.codes import draw_join_code
from server.classes.models import ClassRole, Membership, SchoolClass
from server.comments.models import Message, Note, NoteReader, Thread, ThreadState
from server.database import utc_now
from server.federation.models import ContextTeacher, IdentityProvider, Protocol, ProviderContext
from server.figures.service import FigureService
from server.gradebook import service as gradebook
from server.gradebook.schemas import GradingResult
from server.health import readiness
from server.identity import links
from server.identity.models import Account, ApiToken, BrowserSession, Invitation, Role
from server.identity.secrets import draw_secret_token, sha256_hex
from server.lesson.models import LiveLesson
from server.mails.models import MailSubscription
from server.mails.service import CONFIRM, sign_link_action
from server.marks import rubrics
from server.marks.models import ManualColumn, Override, Rubric
from server.recall.retrievals import today_at_school
from server.regrades.models import Regrade
from server.studio.drafts import ExerciseDraft
from server.studio.models import AuthoredExercise
from server.submissions.models import Submission
from server.warmup import repository as warm_ups
from server.warmup.schemas import WarmUpOption, WarmUpQuestion
from tests.support.service import EXERCISE, Site, fake_verdict

TABLE = (ROOT / "server" / "rights" / "README.md").read_text(encoding="utf-8").split("## Routes")[1]
PEOPLE = ("visitor", "stranger", "student", "assistant", "teacher", "other teacher", "administrator")
ROLES = {"teacher": Role.teacher, "other teacher": Role.teacher, "administrator": Role.administrator}
SEATS = {"student": ClassRole.student, "assistant": ClassRole.assistant, "teacher": ClassRole.teacher}
API = "/api/v1"
WATCHED = "/statusz"  # read with a token, as the API is
LEADS_TO_LOG_IN = "log in"
MISTAKE = "rotation_oubliee"
REFUSED = (401, 403, 404)

#: What a route needs to be reached: else its form is refused before anybody's rights are asked.
JSON: dict[str, Any] = {
    "DELETE /api/v1/me": {"password": "au hasard"},
    "POST /api/v1/submissions": {"exercise": EXERCISE, "code": "x = 1\n"},
    "POST /api/v1/submissions/{submission_id}/comments": {"text": "Bonjour"},
    "PATCH /api/v1/submissions/{submission_id}/comments/{thread_id}": {"state": "settled"},
    "POST /api/v1/classes": {"name": "PSI", "module": "l20"},
    "POST /api/v1/classes/join": {"code": "{code}"},
    "PUT /api/v1/classes/{class_id}/marks/{student}/{module}/{slug}": {"excused": True, "reason": "à l’oral"},
    "PUT /api/v1/classes/{class_id}/assignments/{aid}/decisions/{student}": {"state": "absent"},
    "PATCH /api/v1/classes/{class_id}/marking": {"absent": "zero"},
    "POST /api/v1/classes/{class_id}/columns": {"title": "Oral"},
    "PATCH /api/v1/classes/{class_id}/columns/{column_id}": {"title": "Exposé"},
    "PUT /api/v1/classes/{class_id}/columns/{column_id}/marks": {"marks": []},
    "POST /api/v1/classes/{class_id}/regrades": {"exercise": EXERCISE},
    "PUT /api/v1/classes/{class_id}/names/{module}/{slug}/{group}": {"title": "Une erreur", "explanation": "Ainsi."},
    "POST /api/v1/classes/{class_id}/assignments": {"title": "DM", "exercises": [{"exercise": EXERCISE}]},
    "PATCH /api/v1/classes/{class_id}/assignments/{aid}": {"title": "DM 1"},
    "POST /api/v1/classes/{class_id}/assignments/{aid}/exceptions": {"student": "{student}", "excused": True},
    "POST /soumissions/{submission_id}/pas": {"check": "b"},
    "POST /{module}/previsions": {"question": "rejeux/icp", "answer": "ailleurs"},
}
TEST = "/classes/{class_id}/devoirs/{assignment_id}"
FORMS: dict[str, dict[str, str]] = {
    "POST /{module}/exercices/{slug}/corrige": {"ouvrir": "true", "classe": "{class_id}"},
    "POST /deux-minutes": {"exercice": EXERCISE, "erreur": MISTAKE, "fonction": "composer", "action": "abandonner"},
    "POST /deux-minutes/calculs": {
        "exercice": "l20/calcul_odometrie",
        "erreur": "roues_echangees",
        "jour": "2026-01-05",
        "valeur": "1",
    },
    "POST /deux-minutes/questions/{module}": {"question": "localiser/case", "jour": "2026-01-05", "reponse": "a"},
    "POST /deux-minutes/rappels": {"rappels": "non"},
    "POST /{module}/rappels": {"question": "localiser/case", "jour": "2026-01-05", "reponse": "a"},
    "POST /{module}/exercices/{slug}/chasse": {"erreur": MISTAKE, "fonction": "composer", "action": "abandonner"},
    "POST /{module}/lire/{slug}/corrige": {"ouvrir": "true", "classe": "{class_id}"},
    "POST /classes": {"name": "PSI", "module": "l20"},
    "POST /mes-exercices": {"module": "l20"},
    "POST /mes-exercices/importer": {"module": "l20"},
    "POST /mes-exercices/copier": {"exercice": "{lent}"},
    "POST /classes/{class_id}/eleves": {"action": "retirer", "eleve": "{student}"},
    "POST /classes/{class_id}/reprise": {"action": "donner", "exercice": EXERCISE},
    "POST /classes/{class_id}/groupes": {"action": "liste", "nom": "Lundi", "noms": "Ada"},
    "POST /classes/{class_id}/seance": {"action": "modifier", "exercice": EXERCISE},
    "POST /classes/{class_id}/pour-commencer/reponses": {"question": "1", "reponse": "A"},
    "POST /classes/{class_id}/courriel": {"action": "arreter"},
    "POST /classes/{class_id}/mots": {"exercice": EXERCISE, "texte": "Bonjour"},
    "POST /classes/{class_id}/liste": {"texte": "nom\nLovelace"},
    "POST /classes/{class_id}/reglages": {"name": "PSI"},
    "POST /classes/{class_id}/reglages/moyenne": dict.fromkeys(
        ("non_rendu", "retard", "absence", "sans_reponse"), "zero"
    ),
    "POST /classes/{class_id}/equipe": {"login": "{stranger}", "role": "assistant"},
    "POST /classes/{class_id}/copier": {"name": "PSI"},
    "POST /classes/{class_id}/archiver": {"archiver": "true"},
    "POST /classes/{class_id}/carnet/colonnes": {"titre": "Oral"},
    "POST /classes/{class_id}/carnet/{student}/{assignment_id}": {
        "action": "dispenser",
        "exercice": EXERCISE,
        "motif": "x",
    },
    "POST /classes/{class_id}/devoirs/{aid}/equipes": {"action": "hasard"},
    "POST /classes/{class_id}/devoirs/{aid}/mon-equipe": {"action": "retirer", "eleve": "{student}"},
    "POST /classes/{class_id}/devoirs/{aid}/noter": {"action": "publier"},
    "POST /classes/{class_id}/recalculs": {"exercice": EXERCISE},
    "POST /classes/{class_id}/recalculs/{regrade_id}": {"action": "arreter"},
    "POST /administration/plateforme/{provider_id}": {"action": "suspendre"},
    "POST /classes/{class_id}/plateforme/liste": {"cours": "{tied}"},
    "POST /classes/{class_id}/plateforme": {"action": "envoyer", "cours": "{tied}", "devoir": "{aid}"},
    "POST /etablissement/cours/{context_id}": {"action": "lier", "classe": "{class_id}"},
    f"POST {TEST}/rouvrir": {"eleve": "{student}"},
    "POST /rejoindre/{code}": {"given": "Ada", "family": "Lovelace"},
}
SIGN_IN = "/connexion/etablissement/{provider_id}"
SERVER_ROUTES = (
    *(f"GET /administration/plateforme/{{provider_id}}/{page}" for page in ("essai", "regle", "serveur")),
    *(f"POST /administration/plateforme/{{provider_id}}/{page}" for page in ("regle", "serveur")),
    *(f"GET {SIGN_IN}{page}" for page in ("", "/retour")),
    *(f"POST {SIGN_IN}{page}" for page in ("/deconnexion", "/retour")),
)
OTHER_VALUES = {
    **{name: {"provider_id": "{cas}"} for name in SERVER_ROUTES},
    f"GET {TEST}/composer": {"assignment_id": "{test}"},
    **{f"POST {TEST}/{what}": {"assignment_id": "{test}"} for what in ("commencer", "rendre", "publier", "rouvrir")},
    "GET /{module}/kit/{file}": {"file": "l20.py"},
    "GET /static/{version}/{name:path}": {"version": "source", "name": "img/favicon.svg"},
    "GET /{module}/lire/{slug}": {"slug": "localiser"},
    "POST /{module}/lire/{slug}/corrige": {"slug": "epreuve-corrige"},
    "POST /{module}/hors-ligne": {"module": "l99"},  # an archive takes seconds to make
    "GET /{module}/figures/{name}.svg": {"name": "carto-sigmoide"},
    "GET /{module}/rejeux/{name}": {"name": "lidar"},
    "GET /{module}/manipulations/{name}": {"name": "elastique"},
    "GET /{module}/manipulations/{name}/{file}": {"name": "elastique", "file": "main.js"},
    "GET /agenda/{token}.ics": {"token": "{calendar}"},
    "GET /bienvenue/{token}": {"token": "{invitation}"},
    "POST /bienvenue/{token}": {"token": "{invitation}"},
}
QUERIES = {
    "GET /api/v1/classes/{class_id}/assignments/{aid}/rules": "?student={student}",
    "GET /classes/{class_id}/devoirs/{aid}/pourquoi": "?eleve={student}",
}


def routes(app: FastAPI) -> set[str]:
    """Method and path of each, as the table names them."""
    found = [(route.path, route.methods or set()) for route in iter_route_contexts(app.routes)]
    return {f"{method} {path}".replace(":module}", "}") for path, methods in found for method in methods - {"HEAD"}}


def expected() -> dict[str, dict[str, str]]:
    lines = [line for line in TABLE.splitlines() if line.startswith("| `")]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {name.strip("`"): dict(zip(PEOPLE, outcomes, strict=True)) for name, *outcomes in cells}


class Drawer:
    """Draws nothing."""

    async def ask(self, _question: bytes) -> bytes:
        return gzip.compress(b"<svg/>")

    async def close(self) -> None: ...


class Stage:
    """A class with somebody of each kind, and what a student of it has sent."""

    def __init__(self, site: Site) -> None:
        self.site = site
        tag = uuid4().hex[:8]
        self.accounts = {
            who: Account(role=ROLES.get(who, Role.student), name=who, login=f"{who}-{tag}".replace(" ", "-"))
            for who in PEOPLE[1:]
        }
        self.tokens: dict[str, str] = {}
        self.own_tokens: dict[str, str] = {}
        self.cookies = {who: draw_secret_token() for who in self.accounts}
        with site.database.write() as db:
            db.add_all(self.accounts.values())
            db.flush()
            later = utc_now().replace(year=2100)
            self.made = SchoolClass(name="MPSI", module="l20", join_code=draw_join_code(), join_code_until=later)
            db.add(self.made)
            db.flush()
            for who, account in self.accounts.items():
                self.tokens[who], self.own_tokens[who] = draw_secret_token(), str(uuid4())
                token = {"id": UUID(self.own_tokens[who]), "token_digest": sha256_hex(self.tokens[who])}
                db.add(ApiToken(**token, account_id=account.id, label="essai", expires_at=later))
                cookie = sha256_hex(self.cookies[who])
                db.add(BrowserSession(token_digest=cookie, account_id=account.id, expires_at=later))
                if who in SEATS:
                    db.add(Membership(class_id=self.made.id, account_id=account.id, role=SEATS[who]))
            self.column = ManualColumn(class_id=self.made.id, title="Oral", position=1)
            db.add(self.column)
            self.test = Assignment(class_id=self.made.id, title="Interro", mode=Mode.test, opens_at=utc_now())
            db.add(self.test)
            row = {"account_id": self.accounts["student"].id, "exercise": EXERCISE, "reason": "x", "based_on": []}
            db.add(Override(class_id=self.made.id, points=10.0, **row))
            self.sent = Submission(
                account_id=self.accounts["student"].id, exercise=EXERCISE, source=b"x = 1\n", digest="d", seed=1
            )
            db.add(self.sent)
            ada = self.accounts["student"].id
            self.thread = Thread(
                account_id=ada,
                exercise=EXERCISE,
                work_at=utc_now(),
                by_staff=False,
                state=ThreadState.open,
                check_title="",
            )
            self.note = Note(class_id=self.made.id, exercise=EXERCISE, text="Bonjour")
            db.add_all([self.thread, self.note])
            db.flush()
            db.add(NoteReader(note_id=self.note.id, account_id=ada))
            db.add(Message(thread_id=self.thread.id, author_id=ada, as_staff=False, text="Pourquoi ?"))
            self._give(db)
            self.link = links.create_password_link(db, self.accounts["stranger"], timedelta(hours=1))
            self.invitation = draw_secret_token()
            db.add(Invitation(token_digest=sha256_hex(self.invitation), role=Role.teacher))
            db.flush()
            self._grade(db)
            self.regrade = Regrade(class_id=self.made.id, exercise=EXERCISE, policy="replace")
            self.lesson = LiveLesson(class_id=self.made.id, exercises=[EXERCISE], started_at=utc_now())
            db.add_all((self.regrade, self.lesson))
            db.refresh(self.sent)
            self.group = uuid4().hex[:10]
            db.add(
                BehaviourGroup(
                    id=self.group, exercise=EXERCISE, exercise_version="v1", structure="", projection=0.0,
                    answers=serialize_answers(()), functions=[], example=None,
                )
            )  # fmt: skip
            db.flush()
            db.add(Fingerprint(grading_id=self.sent.grading_id, group_id=self.group))
            db.add(BehaviourName(class_id=self.made.id, group_id=self.group, title="a", explanation="b", question=""))

    def _grade(self, db: Session) -> None:
        """What the student has sent, and a mistake of theirs that has a name."""
        drawn = {"b": {"kind": "fake"}}
        graded = GradingResult(Judgement(fake_verdict("x = 1", 1), figures=drawn, films=drawn), utc_now())
        gradebook.record_grading(db, self.sent.id, graded)  # a stream of events ends
        named = Submission(
            account_id=self.accounts["student"].id, exercise=EXERCISE, source=b"x = 2\n", digest="e", seed=1
        )
        db.add(named)
        db.flush()
        verdict = replace(fake_verdict("outcome: wrong_answer", 1), diagnosis=Diagnosis(MISTAKE, "", ""))
        gradebook.record_grading(db, named.id, GradingResult(Judgement(verdict), utc_now()))

    def _give(self, db: Session) -> None:
        """An assignment for each, which one may delete, with something that differs of it; a platform; a calendar."""
        platform = f"https://moodle-{uuid4().hex}.example"
        addresses = {"authorization_url": platform, "token_url": platform, "keys_url": platform}
        self.provider = IdentityProvider(
            protocol=Protocol.lti, name="Moodle", issuer=platform, client_id="balise", settings=addresses
        )
        db.add(self.provider)
        self.cas = IdentityProvider(
            protocol=Protocol.cas, name="ENT", issuer=f"{platform}/cas", client_id="cas", settings={"service": platform}
        )
        db.add(self.cas)
        db.flush()
        self.course = ProviderContext(provider_id=self.provider.id, context="c")
        db.add(self.course)
        self.tied = ProviderContext(provider_id=self.provider.id, context="d", class_id=self.made.id)
        db.add(self.tied)
        db.flush()
        db.add(ContextTeacher(context_id=self.course.id, account_id=self.accounts["teacher"].id))
        self.mails = MailSubscription(
            class_id=self.made.id, account_id=self.accounts["teacher"].id, address="a@lycee.example", secret="s",
            service_url="https://balise.example",
        )  # fmt: skip
        db.add(self.mails)
        db.flush()
        self.calendar = calendars.renew_calendar_address(db, self.accounts["student"])
        options = (WarmUpOption("A", "1"), WarmUpOption("B", "2"))
        question = WarmUpQuestion("s", EXERCISE, MISTAKE, "Poses", "/", "Combien ?", options, "A", 5)
        warm_ups.add_warm_up_if_absent(db, self.made.id, today_at_school(), [question.to_data()])
        teacher = self.accounts["teacher"].id
        self.authored = AuthoredExercise(author_id=teacher, module="l20", draft=ExerciseDraft().to_data(), digest="")
        self.lent = AuthoredExercise(
            module="l20", draft=ExerciseDraft().to_data(), digest="", in_bank=True, slug=uuid4().hex, number=1
        )
        db.add_all([self.authored, self.lent])
        self.assignments = {who: str(uuid4()) for who in PEOPLE}
        for name in self.assignments.values():
            db.add(Assignment(id=UUID(name), class_id=self.made.id, title="DM", opens_at=utc_now(), team_size=2))
        db.flush()
        names = [*map(UUID, self.assignments.values())]
        db.add_all(AssignedExercise(assignment_id=name, exercise=EXERCISE, position=0) for name in names)
        self.copies = {}
        for name in names:
            column = ManualColumn(class_id=self.made.id, title="À la main", position=2)
            db.add(column)
            db.flush()
            rubric = Rubric(column_id=column.id, assignment_id=name, items=[])
            self.copies[str(name)] = rubrics.anonymous_copy_key(rubric, self.accounts["student"].id)
            db.add(rubric)
        exemptions = {name: Exemption(assignment_id=UUID(name), label="TP1") for name in self.assignments.values()}
        db.add_all(exemptions.values())
        db.flush()
        self.exemptions = {name: str(one.id) for name, one in exemptions.items()}

    def values(self, who: str) -> dict[str, str]:
        return {
            "module": "l20",
            "slug": "poses",
            "name": "b",
            "class_id": str(self.made.id),
            "test": str(self.test.id),
            "assignment_id": self.assignments[who],
            "code": str(self.made.join_code),
            "submission_id": str(self.sent.id),
            "regrade_id": str(self.regrade.id),
            "exercise_id": str(self.authored.id),
            "lent": str(self.lent.id),
            "lesson_id": str(self.lesson.id),
            "group": self.group,
            "aid": self.assignments[who],
            "tied": str(self.tied.id),
            "context_id": str(self.course.id),
            "provider_id": str(self.provider.id),
            "cas": str(self.cas.id),
            "protocol": Protocol.cas,
            "column_id": str(self.column.id),
            "chapter": "noter",
            "copy": self.copies[self.assignments[who]],
            "eid": self.exemptions[self.assignments[who]],
            "token": self.link,
            "invitation": self.invitation,
            "calendar": self.calendar,
            "subscription_id": str(self.mails.id),
            "action": CONFIRM,
            "signature": sign_link_action(self.mails, CONFIRM),
            "student": str(self.accounts["student"].id),
            "stranger": str(self.accounts["stranger"].login),
            "thread_id": str(self.thread.id),
            "note_id": str(self.note.id),
            "phrase_id": str(uuid4()),
            "mistake": MISTAKE,
            "check": "b",
            "token_id": self.own_tokens.get(who, str(uuid4())),
        }

    def ask(self, name: str, who: str) -> str:
        """What the route answers to this person, in the words of the table."""
        method, path = name.split(" ", 1)
        values = self.values(who)
        values |= {key: text.format(**values) for key, text in OTHER_VALUES.get(name, {}).items()}
        address = re.sub(r"\{(\w+)(?::\w+)?\}", lambda found: values[found[1]], path)
        address += QUERIES.get(name, "").format(**values)
        options: dict[str, Any] = {}
        if name in JSON:
            options["json"] = {
                key: text.format(**values) if isinstance(text, str) else text for key, text in JSON[name].items()
            }
        if name in FORMS:
            options["data"] = {key: text.format(**values) for key, text in FORMS[name].items()}
        if name.endswith("/roster"):
            options |= {"content": b"nom\nLovelace\n", "headers": {"Content-Type": "text/csv"}}
        headers = options.pop("headers", {})
        if who in self.accounts and path.startswith((API, WATCHED)):
            headers["Authorization"] = f"Bearer {self.tokens[who]}"
        elif who in self.accounts:
            headers["Cookie"] = f"{SESSION_COOKIE}={self.cookies[who]}"
        self.site.client.cookies.clear()
        answer = self.site.client.request(method, address, headers=headers, **options)
        assert answer.status_code < 500, (name, who, answer.text)
        if answer.headers.get("location", "").startswith("/connexion?suite="):
            return LEADS_TO_LOG_IN
        return str(answer.status_code) if answer.status_code in REFUSED else "yes"


def test_the_table_has_every_route_and_no_other(site: Site) -> None:
    assert list(expected()) == sorted(routes(site.app), key=lambda one: one.split(" ")[::-1])


def test_every_route_does_for_everybody_what_the_table_says(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(readiness, "NOBODY_GRADES_AFTER", timedelta(days=1))  # however slow the machine is
    site.tighten(sign_up_burst=1000, guest_burst=10_000)
    get_service(site.app, FigureService).pictures._drawer = Drawer()  # type: ignore[assignment]
    get_service(site.app, LiveClassViews).max_stream_seconds = 0.0
    found, read_only = {}, Stage(site)
    for name in expected():
        stage = read_only if name.startswith("GET ") else Stage(site)
        found[name] = {who: stage.ask(name, who) for who in PEOPLE}
    assert found == expected()
