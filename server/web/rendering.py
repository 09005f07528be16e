"""Templates to answers. Other rooms that have pages (accounts, errors) render theirs here too."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from functools import lru_cache
from hashlib import blake2b, sha256
from http import HTTPStatus
from typing import Any, TypeVar

from fastapi import Request, Response
from fastapi.responses import HTMLResponse
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from graders.typography import french
from server.base import root_path, school_time
from server.base.app_services import get_service
from server.base.files import TEMPLATES
from server.base.http import SAFE_METHODS
from server.base.version import VERSION
from server.course import Course, Module
from server.identity.models import Account
from server.marks import means
from server.marks.own import describe_column_mark
from server.text.plain import show_invisible_characters
from server.text.python_colours import colour_python_block
from server.text.repeated_lines import fold_repeated_lines
from server.text.said import cached_message_html
from server.text.spoken import html_to_spoken_text
from server.web import assets, threads, verdicts, views, words
from server.web.form_identity import account_form_key, insert_account_key_in_forms
from server.web.schemas import AccountView, CurrentModuleView

TAG_DIGITS = 24  # of the SHA-256 of a page


@lru_cache(maxsize=1)
def jinja_environment() -> Environment:
    """The one environment: everything is escaped, a name that is not in the context is an error."""
    jinja = Environment(
        loader=FileSystemLoader(TEMPLATES),
        auto_reload=False,  # each page would ask the disk of a dozen files whether they are still the same
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    jinja.filters.update(
        french=french, sentence=typeset_verdict_message, visible=show_invisible_characters,
        folded=fold_repeated_lines, ticks=render_backquotes_as_code, python=highlight_python,
        said=render_personal_message, spoken=html_to_spoken_text,
        iso_moment=words.format_iso_time, short_moment=words.format_short_time, long_day=words.format_long_day,
        decimal=means.format_number,
        points_or_dash=format_points_or_dash,
        moment=render_time_element, mark=words.format_mark, points=words.format_points,
        exercise_href=views.exercise_href, lesson_href=views.lesson_href,
        outcome_title=verdicts.outcome_in_words,
        state_label=threads.thread_state_label, subject=threads.describe_thread_subject,
        shorten=threads.shorten_message,
    )  # fmt: skip
    jinja.globals.update(
        static=assets.static_url, has_katex=assets.is_frontend_built, plural=words.count_with_noun,
        time_zone=school_time.time_zone,
        mean_formula=means.FORMULA, column_mark_text=describe_column_mark, version=VERSION,
    )  # fmt: skip
    return jinja


def format_points_or_dash(points: float | None) -> str:
    """Points rounded to the hundredth, « — » for none."""
    return "—" if points is None else means.format_points(points)


def render_backquotes_as_code(message: str) -> Markup:
    """Plain text in which `…` marks code: everything else is escaped, and its invisible characters shown."""
    parts = str(escape(show_invisible_characters(message))).split("`")
    if len(parts) % 2 == 0:
        return Markup("`".join(parts))
    return Markup("".join(f"<code>{part}</code>" if odd % 2 else part for odd, part in enumerate(parts)))


def render_time_element(when: datetime | None, *, long: bool = False) -> Markup:
    """Render a time on the school's clock as a `<time>` element; a dash for none."""
    if when is None:
        return Markup("—")
    text = words.format_long_time(when) if long else words.format_short_time(when)
    return Markup('<time datetime="{}">{}</time>').format(words.format_iso_time(when), text)


def typeset_verdict_message(message: str) -> str:
    """A verdict's message in French typography; the lines below its first are code and traces, left as they are."""
    first, *rest = message.split("\n")
    return "\n".join([french(first), *rest])


def highlight_python(code: str) -> Markup:
    """Return Python with colours, a student's too: the text is escaped, and read in linear time."""
    return Markup(colour_python_block(show_invisible_characters(code)))


def render_personal_message(message: str) -> Markup:
    """Render a message that one person wrote to another."""
    return Markup(cached_message_html(message))


def build_account_view(account: Account | None) -> AccountView:
    if account is None:
        return AccountView("visitor", "", account_form_key(None))
    return AccountView(account.role, account.name, account_form_key(account))  # type: ignore[arg-type]


def _find_current_module(request: Request, modules: Mapping[str, Module]) -> CurrentModuleView | None:
    """The module that the address is in, when there is something to search there."""
    module = modules.get(request.path_params.get("module", ""))
    if module is None or not module.lessons:
        return None
    return CurrentModuleView(module.slug, module.label, request.url.path == f"/{module.slug}/recherche")


def _list_module_links(request: Request, course: Course) -> list[tuple[str, str, str]]:
    """Slug, number and title of each: the edition that the address is in, else the last."""
    here = course.modules.get(request.path_params.get("module", ""))
    latest = [here if here and course.newer_edition(here.slug) is module else module for module in course.latest]
    return [(module.slug, module.label, module.title) for module in latest]


def _return_address_after_login(request: Request, context: Mapping[str, Any]) -> str:
    """Where who logs in from this page comes back to: the page, or where it was to lead."""
    if "after" in context:
        return str(context["after"])
    if request.method not in SAFE_METHODS:
        return "/"
    query = f"?{request.url.query}" if request.url.query else ""
    return f"{request.url.path}{query}"


def render_page(
    request: Request,
    template: str,
    account: Account | None,
    *,
    status: int = 200,
    headers: Mapping[str, str] | None = None,
    **context: Any,
) -> HTMLResponse:
    """A whole page: `template` extends `base.html`, which shows `account` and the modules of the course."""
    course = get_service(request.app, Course)
    surroundings = {
        "modules": _list_module_links(request, course),
        "title_of": course.title_of_exercise,
        "title_at": course.title_at_address,
        "here": _find_current_module(request, course.modules),
        "path": request.url.path,
        "back": _return_address_after_login(request, context),
    }
    html = (
        jinja_environment()
        .get_template(template)
        .render(account=build_account_view(account), **surroundings, **context)
    )
    html = insert_account_key_in_forms(html, account_form_key(account))
    # A page shows one person's own work: no shared cache may store it.
    all_headers = {"Cache-Control": "private, no-cache", **(headers or {})}
    return _tagged_response(request, root_path.with_external_paths(html).encode(), status, all_headers)


def _tagged_response(request: Request, content: bytes, status: int, headers: dict[str, str]) -> HTMLResponse:
    """Return the page with an ETag of its uncompressed content; status 304 where the browser has that content."""
    if request.method == "GET" and status == HTTPStatus.OK:
        tag = f'W/"{sha256(content).hexdigest()[:TAG_DIGITS]}"'
        headers["ETag"] = tag
        if tag in request.headers.get("if-none-match", ""):
            return HTMLResponse(None, HTTPStatus.NOT_MODIFIED, {**headers, "Vary": "Accept-Encoding"})
    return HTMLResponse(content, status, headers)


Answer = TypeVar("Answer", bound=Response)


def add_etag(request: Request, response: Answer) -> Answer:
    """The same answer with a tag of its content; without its content for a browser that has it already."""
    tag = f'W/"{blake2b(bytes(response.body), digest_size=12).hexdigest()}"'
    response.headers["ETag"] = tag
    if tag in request.headers.get("if-none-match", ""):
        response.status_code, response.body = HTTPStatus.NOT_MODIFIED, b""
        del response.headers["content-length"]
    return response


def render_fragment(template: str, account: Account | None, *, back: str, **context: Any) -> HTMLResponse:
    """A part of a page, for a script that puts it in place; `back` is where who logs in from there comes back to."""
    html = jinja_environment().get_template(template).render(account=build_account_view(account), back=back, **context)
    body = insert_account_key_in_forms(html, account_form_key(account))
    return HTMLResponse(root_path.with_external_paths(body), headers={"Cache-Control": "private, no-store"})
