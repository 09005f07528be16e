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
from server.text.python_colours import colour_block
from server.text.repeated_lines import fold_repeated_lines
from server.text.said import message_html
from server.text.spoken import html_to_spoken_text
from server.web import assets, threads, verdicts, views, words
from server.web.form_identity import account_key, name_account_in_forms
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
        french=french, sentence=sentence, visible=show_invisible_characters, folded=fold_repeated_lines,
        ticks=ticks, python=python, said=written, spoken=html_to_spoken_text,
        iso_moment=words.iso_moment, short_moment=words.short_moment, long_day=words.long_day,
        decimal=means.format_number,
        points_or_dash=points_or_dash,
        moment=moment, mark=words.format_mark, points=words.format_points,
        exercise_href=views.exercise_href, lesson_href=views.lesson_href,
        outcome_title=verdicts.outcome_title,
        state_label=threads.state_label, subject=threads.thread_subject, shorten=threads.shorten,
    )  # fmt: skip
    jinja.globals.update(
        static=assets.static_url, has_katex=assets.is_built, plural=words.plural, time_zone=school_time.time_zone,
        mean_formula=means.FORMULA, column_mark_text=describe_column_mark, version=VERSION,
    )  # fmt: skip
    return jinja


def points_or_dash(points: float | None) -> str:
    """Points rounded to the hundredth, « — » for none."""
    return "—" if points is None else means.format_points(points)


def ticks(message: str) -> Markup:
    """Plain text in which `…` marks code: everything else is escaped, and its invisible characters shown."""
    parts = str(escape(show_invisible_characters(message))).split("`")
    if len(parts) % 2 == 0:
        return Markup("`".join(parts))
    return Markup("".join(f"<code>{part}</code>" if odd % 2 else part for odd, part in enumerate(parts)))


def moment(when: datetime | None, *, long: bool = False) -> Markup:
    """Render a time on the school's clock as a `<time>` element; a dash for none."""
    if when is None:
        return Markup("—")
    text = words.long_moment(when) if long else words.short_moment(when)
    return Markup('<time datetime="{}">{}</time>').format(words.iso_moment(when), text)


def sentence(message: str) -> str:
    """A verdict's message in French typography; the lines below its first are code and traces, left as they are."""
    first, *rest = message.split("\n")
    return "\n".join([french(first), *rest])


def python(code: str) -> Markup:
    """Return Python with colours, a student's too: the text is escaped, and read in linear time."""
    return Markup(colour_block(show_invisible_characters(code)))


def written(message: str) -> Markup:
    """Render a message that one person wrote to another."""
    return Markup(message_html(message))


def account_view(account: Account | None) -> AccountView:
    if account is None:
        return AccountView("visitor", "", account_key(None))
    return AccountView(account.role, account.name, account_key(account))  # type: ignore[arg-type]


def _here(request: Request, modules: Mapping[str, Module]) -> CurrentModuleView | None:
    """The module that the address is in, when there is something to search there."""
    module = modules.get(request.path_params.get("module", ""))
    if module is None or not module.lessons:
        return None
    return CurrentModuleView(module.slug, module.label, request.url.path == f"/{module.slug}/recherche")


def _modules(request: Request, course: Course) -> list[tuple[str, str, str]]:
    """Slug, number and title of each: the edition that the address is in, else the last."""
    here = course.modules.get(request.path_params.get("module", ""))
    latest = [here if here and course.newer(here.slug) is module else module for module in course.latest]
    return [(module.slug, module.label, module.title) for module in latest]


def _back(request: Request, context: Mapping[str, Any]) -> str:
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
        "modules": _modules(request, course),
        "title_of": course.title_of,
        "title_at": course.title_at,
        "here": _here(request, course.modules),
        "path": request.url.path,
        "back": _back(request, context),
    }
    html = jinja_environment().get_template(template).render(account=account_view(account), **surroundings, **context)
    html = name_account_in_forms(html, account_key(account))
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


def with_etag(request: Request, answer: Answer) -> Answer:
    """The same answer with a tag of its content; without its content for a browser that has it already."""
    tag = f'W/"{blake2b(bytes(answer.body), digest_size=12).hexdigest()}"'
    answer.headers["ETag"] = tag
    if tag in request.headers.get("if-none-match", ""):
        answer.status_code, answer.body = HTTPStatus.NOT_MODIFIED, b""
        del answer.headers["content-length"]
    return answer


def render_fragment(template: str, account: Account | None, *, back: str, **context: Any) -> HTMLResponse:
    """A part of a page, for a script that puts it in place; `back` is where who logs in from there comes back to."""
    html = jinja_environment().get_template(template).render(account=account_view(account), back=back, **context)
    body = name_account_in_forms(html, account_key(account))
    return HTMLResponse(root_path.with_external_paths(body), headers={"Cache-Control": "private, no-store"})
