"""The readers of strangers' bytes, and the inputs of routes that each of them reads.

An input is named by its kind and its name: `form:texte`, `query:q`, `body:CellRunInput.code`; or
`raw:<module>.<function>`, for a function that reads of a request what no parameter tells. Numbers, UUIDs, dates and
choices are read by pydantic.
"""

from __future__ import annotations

import html
import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from hmac import compare_digest
from typing import Any
from urllib.parse import parse_qsl

from pydantic import TypeAdapter
from starlette.datastructures import FormData
from starlette.requests import Request

from graders.core.answers.numbers import read_number
from graders.typography import french, unaccented
from server.api.assignment_schemas import AssignmentIn
from server.api.column_schemas import ColumnIn, TypedMarksIn
from server.api.schemas import NewSubmission
from server.assignments.groups import find_named_students, parse_group_label
from server.base.errors import InvalidFields, ServiceError
from server.base.forms import decode_large_form
from server.base.http import accepted_encodings, bearer_token, local_path, session_token, visitor_key
from server.base.http_protocol import MAX_HEAD_BYTES
from server.base.root_path import with_external_paths
from server.base.routing import FilteringRouter
from server.base.school_time import parse_field
from server.base.validation import encode_bounded, parse_uuid
from server.board.extracts import anonymise_extract, extract_function
from server.classes.codes import parse_join_code
from server.classes.encodings import redecode
from server.classes.folding import normalise_name
from server.classes.roster import read_roster
from server.classes.schemas import validate_class_name, validate_guest_name
from server.classes.sheets import read_rows, to_csv
from server.comments.difference import diff_lines, split_lines
from server.comments.models import TEXT_LENGTH
from server.comments.schemas import normalise_message_text
from server.comments.side_by_side import compare_side_by_side
from server.desk.assignments.forms import parse_assignment, parse_exemption
from server.desk.rubrics.forms import parse_copy, read_copy
from server.desk.rubrics.forms import parse_form as parse_rubric_form
from server.desk.rubrics.forms import read_form as read_rubric_form
from server.desk.studio.forms import read_exercise_draft as read_exercise_form
from server.desk.studio.forms import read_picked_options
from server.desk.studio.views import render_statement
from server.federation import registration as servers
from server.federation import rule_forms
from server.federation.cas.messages import is_service_ticket, parse_logout_ticket
from server.federation.lti import registration
from server.federation.lti.launch import target_path
from server.federation.lti.sign_in import LaunchInitiation
from server.federation.rules import Rule
from server.federation.tokens import read_header
from server.hunts.service import MAX_TYPED_CHARACTERS
from server.identity.schemas import validate_new_account, validate_new_password, validate_token_label
from server.identity.secrets import normalise_typed_token, sha256_hex
from server.mails.service import parse_mail_address
from server.marks.cells import ascii_slug, write_french_csv, write_plain_csv
from server.marks.rubric_items import RubricItem, parse_rubric_item
from server.marks.typed import parse_mark_comment, parse_typed_mark
from server.reading import search
from server.routers import ROUTERS
from server.sandbox.foreign_characters import describe_odd_letters, find_foreign_characters, latin_spelling
from server.sandbox.policy import Policy
from server.sandbox.sources import import_set_of_program, require_text
from server.steps.calls import MAX_CHARACTERS, parse_call, parse_stdin_lines, parse_value
from server.studio.drafts import ExerciseDraft
from server.studio.import_drafts import ImportRefused
from server.studio.importing import import_exercise_file
from server.submissions.service import digest_code
from server.text.lines import normalise_lines, require_normalised_line
from server.text.python_colours import colour_python_lines_uncached
from server.text.said import render_message_html
from server.web.form_identity import decode_resent_fields, insert_account_key_in_forms
from server.web.form_version import form_version_tag
from server.web.rendering import render_backquotes_as_code, typeset_verdict_message
from tests.support.quick import the_course
from tests.support.shapes import JSON, MARKDOWN, PROGRAMS, TEXTS, Shape

#: The longest that each may be: a request's body, its head, a program, a message, a text of a verdict.
BODY, HEAD, CODE, MESSAGE, SENTENCE = 512 * 1024, MAX_HEAD_BYTES, 64 * 1024, TEXT_LENGTH, 4000
CRITERIA = (RubricItem("a", "Clarté", 4.0),)
ANYTHING: Mapping[str, Shape] = {**TEXTS, **MARKDOWN, **PROGRAMS, **JSON}


@dataclass(frozen=True)
class Reader:
    """It reads a text of at most `longest` characters; `inputs` are where strangers give it one."""

    name: str
    read: Callable[[str], object]
    longest: int
    shapes: Mapping[str, Shape]
    inputs: str = ""


def _form(names: str, read: Callable[[FormData], object]) -> Callable[[str], object]:
    return lambda text: read(FormData([(name, text) for name in names.split()]))


def _encoded(read: Callable[[bytes], object]) -> Callable[[str], object]:
    return lambda text: read(text.encode("utf-8", "replace"))


def _body(model: Any) -> Callable[[str], object]:
    """As FastAPI reads it: as JSON, then as each of the model's fields."""
    adapter = TypeAdapter(model)

    def read(text: str) -> None:
        value = json.loads(text)
        for body in (value, *({name: value} for name in model.model_fields)):
            try:
                adapter.validate_python(body)
            except ValueError as error:
                error.errors()  # type: ignore[attr-defined]

    return read


ROUTERS_TO_ASK = [FilteringRouter(router) for router in ROUTERS]


def _matched(text: str) -> None:
    for begin in ("/", "/static/a/", "/soumissions/a/figures/"):
        for router in ROUTERS_TO_ASK:
            router.matches({"type": "http", "method": "GET", "path": begin + text})


def _cookie(text: str) -> object:
    headers = [(name, text.encode("utf-8", "replace")) for name in (b"cookie", b"accept-encoding")]
    request = Request(
        {"type": "http", "headers": [*headers, (b"authorization", f"Bearer {text}".encode("utf-8", "replace"))]}
    )
    return session_token(request), bearer_token(request)


def _large_form(text: str) -> object:
    scope = {"headers": [(b"content-type", b"application/x-www-form-urlencoded")]}
    return decode_large_form(scope, text.encode("utf-8", "replace"))


def _imported_file(text: str) -> None:
    for ending in ("zip", "xml", "yaml", "json", "ipynb"):
        with suppress(ImportRefused):
            import_exercise_file(f"a.{ending}", text.encode("utf-8", "replace"))


@cache
def _index() -> search.SearchIndex:
    return search.load_index(the_course().modules["l20"])


#: Names and choices of addresses and forms: compared with what there is, and read as a UUID where it is one.
IDENTITIES = """
    path:aid path:assignment_id path:chapter path:check path:protocol
    path:class_id path:code path:column_id path:copy path:eid path:exercise_id path:file
    path:group path:lesson_id
    path:mistake path:module path:name path:regrade_id path:slug path:student path:submission_id path:thread_id
    path:version
    query:change query:identifiant
    query:choix query:class query:colonne query:columns query:depuis query:devoir query:eleve
    query:encoding query:erreur query:erreurs query:exercice query:format query:genre query:groupe query:reprendre
    query:mur query:student query:sujet query:tri query:verification query:version
    header:Idempotency-Key header:last-event-id
    form:absence form:action form:approbation form:attendu form:bonus form:choix form:confirme form:defi form:devoir
    form:duree form:edition form:eleve form:erreur form:etat form:exercice form:garder form:groupe form:lien form:ligne
    form:derniere form:combien form:presents form:deja form:equipe form:question
    form:module form:non_rendu form:nouveaux form:phrase form:portee form:regle form:retard form:role
    form:sans_reponse form:semaines form:classe form:contenu form:cours form:verification form:version form:code
    body:NewSubmission.exercise body:NewRegrade.exercise body:WeightedIn.exercise body:NewClass.module
    body:NewComment.check body:ReplayBody.check body:LessonAnswerInput.question body:LessonAnswerInput.answer
"""


def _caught(read: Callable[[], object]) -> object:
    try:
        return read()
    except ServiceError as refused:
        return refused


def _server_form(text: str) -> object:
    form = dict.fromkeys(("name", "issuer", "service", "client_id", "client_secret", "scopes"), text)
    return _caught(lambda: servers.parse_oidc(form)), _caught(lambda: servers.parse_cas(form))


def _rule(text: str) -> object:
    form = dict.fromkeys(rule_forms.FIELDS, text)
    rule, claims = _caught(lambda: rule_forms.parse_rule(form)), _caught(lambda: rule_forms.parse_claims(text))
    return rule_forms.try_rule(rule, claims) if isinstance(rule, Rule) and isinstance(claims, dict) else rule


def _platform_form(form: FormData) -> object:
    values = {name: value for name, value in form.items() if isinstance(value, str)}
    try:
        return registration.parse_form(values)
    except InvalidFields as refused:
        return refused.problems


READERS: tuple[Reader, ...] = (
    Reader("a mail address", lambda text: _caught(lambda: parse_mail_address(text)), BODY, TEXTS, "form:adresse"),
    Reader(
        "the signature of a link",
        lambda text: compare_digest(b"x" * 64, text.encode("utf-8", "replace")),
        HEAD,
        TEXTS,
        "path:signature path:subscription_id path:action",
    ),
    Reader("an identity", lambda text: parse_uuid(text, "inconnu"), BODY, TEXTS, IDENTITIES),
    Reader(
        "a line",
        lambda text: require_normalised_line(text, 200, "Trop long."),
        BODY,
        TEXTS,
        "form:title form:titre body:ColumnIn.title body:ColumnChange.title body:AssignmentIn.title "
        "body:AssignmentChange.title body:AssignmentIn.groups body:AssignmentChange.groups body:NewName.title "
        "body:ExceptionIn.group",
    ),
    Reader("a group's name", parse_group_label, BODY, TEXTS, "form:nom query:nom"),
    Reader("names of students", lambda text: find_named_students((), text), BODY, TEXTS, "form:noms"),
    Reader(
        "lines",
        normalise_lines,
        BODY,
        TEXTS,
        "form:explanation form:question form:motif body:NewName.explanation body:NewName.question "
        "body:ExceptionIn.reason body:NewMark.reason body:NewDecision.reason",
    ),
    Reader(
        "a new account's name", lambda text: validate_new_account(text, "a@b.fr", "x" * 12), BODY, TEXTS, "form:name"
    ),
    Reader("a login", lambda text: validate_new_account("Ada", text, "x" * 12), BODY, TEXTS, "form:login"),
    Reader(
        "a password",
        lambda text: validate_new_password(text, login="ada", name="Ada"),
        BODY,
        TEXTS,
        "form:password form:new_password body:Proof.password",
    ),
    Reader("a token's label", validate_token_label, BODY, TEXTS, "form:label"),
    Reader(
        "a token",
        lambda text: sha256_hex(normalise_typed_token(text)),
        BODY,
        TEXTS,
        "path:token query:code query:state form:state",
    ),
    Reader("a class's name", validate_class_name, BODY, TEXTS, "body:NewClass.name"),
    Reader("a class's code", parse_join_code, HEAD, TEXTS, "body:JoinCode.code"),
    Reader("a guest's name", lambda text: validate_guest_name(text, text), BODY, TEXTS, "form:given form:family"),
    Reader("a message", normalise_message_text, BODY, TEXTS, "form:texte body:NewComment.text"),
    Reader("a message that is shown", render_message_html, MESSAGE, {**TEXTS, **MARKDOWN}),
    Reader("the form of an address", _matched, HEAD, TEXTS, "raw:server.base.routing.FilteringRouter.matches"),
    Reader("a next address", local_path, BODY, TEXTS, "query:suite form:suite form:retour"),
    Reader("a form that comes back", decode_resent_fields, BODY, {**TEXTS, **JSON}, "form:reprise"),
    Reader("a mark", lambda text: parse_typed_mark(text, 20.0), BODY, TEXTS, "form:points form:sur form:coefficient"),
    Reader("a comment on a mark", parse_mark_comment, BODY, TEXTS, "body:TypedMarkIn.comment"),
    Reader("a moment", lambda text: parse_field(text, "la date"), BODY, TEXTS, "form:date form:rentree"),
    Reader(
        "an assignment's form",
        _form("title opens_at due_at closes_at late weight exercice mode", lambda form: parse_assignment(form, None)),
        BODY,
        TEXTS,
        "raw:server.desk.assignments.forms.checked_exercises raw:server.desk.assignments.forms.checked_groups "
        "raw:server.desk.assignments.forms.submitted_assignment_values raw:server.desk.assignments.forms.field_text "
        "raw:server.desk.assignments.routes.create_assignment raw:server.desk.assignments.routes.update_assignment",
    ),
    Reader(
        "a rubric's form",
        _form(
            "titre coefficient c-0-titre c-0-points c-0-mots c-1-mots",
            lambda form: parse_rubric_form(read_rubric_form(form)),
        ),
        BODY,
        TEXTS,
        "raw:server.desk.rubrics.forms.read_form raw:server.desk.rubrics.routes.save_rubric",
    ),
    Reader("a rubric's words", lambda text: parse_rubric_item("", "a", "4", text), BODY, TEXTS),
    Reader(
        "a copy's form",
        _form("p-a r-a remarque", lambda form: parse_copy(CRITERIA, read_copy(form, CRITERIA))),
        BODY,
        TEXTS,
        "raw:server.desk.rubrics.forms.read_copy raw:server.desk.rubrics.routes.mark_copy",
    ),
    Reader(
        "a teacher's exercise",
        _form(
            "titre enonce solution v-0-c-0-appel v-0-fichiers ecart-0 e-0-programme raison-0123456789ab erreur",
            lambda form: (read_exercise_form(form, ExerciseDraft()).digest, read_picked_options(form, "erreur")),
        ),
        BODY,
        TEXTS,
        "raw:server.desk.studio.forms.read_exercise_draft raw:server.desk.studio.forms._text_field "
        "raw:server.desk.studio.forms._with_tolerances raw:server.desk.studio.forms.read_picked_options "
        "raw:server.desk.studio.routes.save_exercise",
    ),
    Reader(
        "an imported file",
        _imported_file,
        BODY,
        {**TEXTS, **JSON},
        "raw:server.desk.studio.forms.read_upload raw:server.desk.studio.routes.import_exercises",
    ),
    Reader(
        "a statement",
        lambda text: render_statement(the_course(), "l20", text),
        BODY,
        {**TEXTS, **MARKDOWN},
        "form:enonce",
    ),
    Reader(
        "an exemption's form",
        _form("eleve groupe opens_at due_at closes_at time_factor reason", parse_exemption),
        BODY,
        TEXTS,
        "raw:server.desk.assignments.forms.parse_exemption "
        "raw:server.desk.assignments.forms.submitted_exemption_values",
    ),
    Reader(
        "a launch's begin",
        lambda text: (
            LaunchInitiation(text, text, text).query(),
            _caught(lambda: target_path(f"https://a.fr/{text}", "https://a.fr")),
        ),
        BODY,
        TEXTS,
        "query:iss query:login_hint query:target_link_uri query:client_id query:lti_message_hint "
        "query:lti_deployment_id query:openid_configuration query:registration_token form:openid_configuration "
        "form:registration_token form:iss form:login_hint form:target_link_uri form:client_id form:lti_message_hint "
        "form:lti_deployment_id form:error",
    ),
    Reader(
        "a signed token",
        lambda text: [_caught(partial(read_header, token)) for token in (text, f"{text}.a.b")],
        BODY,
        {**TEXTS, **JSON},
        "form:id_token",
    ),
    Reader(
        "a platform's form",
        _form("name issuer client_id authorization_url token_url keys_url deployments frames", _platform_form),
        BODY,
        TEXTS,
        "form:deploiement raw:server.pages.school.lti_forms._read_text_fields",
    ),
    Reader("a server's form", _server_form, BODY, TEXTS, "raw:server.pages.school.server_forms._read_text_fields"),
    Reader("a rule's form", _rule, BODY, ANYTHING, "raw:server.pages.school.rules.change_rule"),
    Reader(
        "the end of a session",
        lambda text: (_caught(lambda: parse_logout_ticket(text)), _caught(lambda: read_header(text))),
        BODY,
        ANYTHING,
        "form:logoutRequest form:logout_token",
    ),
    Reader(
        "an answer of a system",
        lambda text: (sha256_hex(text), is_service_ticket(text)),
        HEAD,
        TEXTS,
        "query:etat query:ticket query:iss query:error raw:server.pages.school.entries.complete_provider_sign_in "
        "raw:server.pages.school.entries.redirect_to_provider",
    ),
    Reader("a search", lambda text: (_index().find_passages(text), normalise_name(text)), HEAD, TEXTS, "query:q"),
    Reader("a list", _encoded(read_roster), BODY, TEXTS, "raw:server.api.classes.import_list"),
    Reader(
        "a list read again",
        lambda text: redecode(text, "cp1252", "utf-8"),
        BODY,
        TEXTS,
        "raw:server.desk.people.list_import._form_text raw:server.desk.people.list_import.read_list_form "
        "raw:server.desk.people.management.import_list",
    ),
    Reader("a list written again", lambda text: to_csv(read_rows(text.encode("utf-8", "replace")).rows), BODY, TEXTS),
    Reader("a call", parse_call, MAX_CHARACTERS, {**TEXTS, **PROGRAMS}, "body:CallBody.call"),
    Reader("a standard input", parse_stdin_lines, MAX_CHARACTERS, TEXTS, "body:CallBody.stdin"),
    Reader(
        "a value",
        parse_value,
        MAX_TYPED_CHARACTERS,
        {**TEXTS, **PROGRAMS},
        "form:valeur form:erreur form:fonction form:exercice form:chemin",
    ),
    Reader(
        "a program",
        lambda text: digest_code(encode_bounded(text, CODE).decode()),
        BODY,
        {**TEXTS, **PROGRAMS},
        "body:NewSubmission.code body:CellRunInput.code body:CallBody.code body:CallBody.after body:CellBody.code "
        "raw:server.pages.routes._read_code_field "
        "raw:server.pages.own_run.run_typed_call "
        "raw:server.pages.routes.save_test_work raw:server.pages.routes.submit_attempt",
    ),
    Reader("a program in colours", colour_python_lines_uncached, CODE, {**TEXTS, **PROGRAMS}),
    Reader("a program before it is opened", _encoded(lambda code: require_text(code, Policy())), CODE, ANYTHING),
    Reader("a program's imports", _encoded(lambda code: import_set_of_program(code, None)), CODE, PROGRAMS),
    Reader(
        "a program's foreign characters",
        lambda text: find_foreign_characters(text.split("\n")),
        CODE,
        {**TEXTS, **PROGRAMS},
    ),
    Reader("a name in other letters", lambda text: (latin_spelling(text), describe_odd_letters(text)), CODE, TEXTS),
    Reader(
        "a program beside another", lambda text: compare_side_by_side(text, f"{text[5:]}a"), CODE, {**TEXTS, **PROGRAMS}
    ),
    Reader(
        "a program that has changed",
        lambda text: diff_lines(split_lines(text), split_lines(text[::-1])),
        CODE,
        {**TEXTS, **PROGRAMS},
    ),
    Reader(
        "an extract",
        lambda text: anonymise_extract(extract_function(f"def f(a):\n    {text}", ["f"]), frozenset({"ada"})),
        CODE,
        {**TEXTS, **PROGRAMS},
    ),
    Reader(
        "an answer",
        read_number,
        CODE,
        {**TEXTS, **PROGRAMS},
        "body:NewSubmission.answers form:reponse raw:server.reading.routes.mark_retrieval_answer "
        "raw:server.pages.answers._read_placed_steps raw:server.pages.answers._read_typed_answer "
        "raw:server.pages.answers._read_ticked_options",
    ),
    Reader(
        "a sentence of a verdict",
        lambda text: (render_backquotes_as_code(text), typeset_verdict_message(text), french(text)),
        SENTENCE,
        TEXTS,
    ),
    Reader("a name to file by", lambda text: (unaccented(text), ascii_slug(text, "x")), SENTENCE, TEXTS),
    Reader(
        "a cell of an export",
        lambda text: (*write_french_csv([text], [[text]]), *write_plain_csv([text], [[text]])),
        SENTENCE,
        TEXTS,
    ),
    Reader(
        "a page",
        lambda text: insert_account_key_in_forms(with_external_paths(html.escape(text)), "x"),
        BODY,
        TEXTS,
    ),
    Reader(
        "a form's version",
        lambda text: form_version_tag({"a": text}),
        BODY,
        TEXTS,
        "raw:server.pages.form_state.read_base_version raw:server.pages.form_state.require_same_tests "
        "raw:server.web.form_version.require_form_version raw:server.web.form_identity.resendable_text_fields",
    ),
    Reader(
        "a column's form",
        lambda text: (parse_typed_mark(text, 20.0), parse_mark_comment(text)),
        BODY,
        TEXTS,
        "raw:server.desk.marks.column_routes._save_column raw:server.desk.marks.column_routes._save_marks "
        "raw:server.desk.marks.column_routes.change_column raw:server.desk.marks.column_views.read_marks "
        "raw:server.desk.marks.routes.change_mark",
    ),
    Reader(
        "a large form",
        _large_form,
        BODY,
        TEXTS,
        "raw:server.base.forms.decode_large_form raw:server.web.form_identity.read_form "
        "raw:server.web.form_identity.require_same_account",
    ),
    Reader(
        "a query string",
        lambda text: parse_qsl(text, keep_blank_values=True),
        HEAD,
        TEXTS,
        "raw:server.replays.routes._find_and_compute",
    ),
    Reader("the body of a submission", _body(NewSubmission), BODY, JSON),
    Reader("the body of an assignment", _body(AssignmentIn), BODY, JSON),
    Reader("the body of a column", _body(ColumnIn), BODY, JSON),
    Reader("the body of marks", _body(TypedMarksIn), BODY, JSON),
    Reader(
        "a header",
        lambda text: (_cookie(text), accepted_encodings(text), visitor_key(text)),
        HEAD,
        TEXTS,
        """
        raw:server.api.routes.PrefixedApiRouter.matches
        raw:server.base.http.cookie_value raw:server.base.http.problem_document
        raw:server.base.middleware.RefusedEncodingsMiddleware.__call__
        raw:server.base.middleware.BodyLimitMiddleware.__call__ raw:server.client.routes.download_client
        raw:server.base.http.bearer_token raw:server.base.turns.FairTurnsMiddleware.__call__
        raw:server.base.middleware.BodyLimitMiddleware._read raw:server.base.middleware.RequestLogMiddleware.__call__
        raw:server.base.middleware._is_forged raw:server.base.middleware._visitor_bytes
        raw:server.base.root_path.RootPathMiddleware.__call__
        raw:server.base.root_path.RootPathMiddleware._scope_inside_root_path
        raw:server.base.root_path.service_url raw:server.desk.people.routes.show_class
        raw:server.desk.people.management._render_settings raw:server.web.forms.redirect_to_login
        raw:server.health.routes.show_metrics raw:server.pages.drawn.send_film
        raw:server.pages.school.launches._open_launch_session
        raw:server.pages.school.launches._render_no_cookies_page
        raw:server.replays.routes._compressed_response raw:server.web.assets._PrecompressedStaticFiles.file_response
        raw:server.web.errors.does_client_want_json raw:server.web.form_identity.referring_page_path
        raw:server.web.form_identity.build_refusal_context
        raw:server.web.rendering._return_address_after_login raw:server.web.rendering._find_current_module
        raw:server.web.rendering._list_module_links raw:server.web.rendering._tagged_response
        raw:server.web.rendering.render_page raw:server.web.rendering.add_etag
        """,
    ),
)
