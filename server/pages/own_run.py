"""« Exécuter » without scripts: a call of one's own, the file as it is, a whole program with what it reads, or a small
program behind a class.

The result is shown on a page, and is no attempt.
"""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import Response
from starlette.concurrency import run_in_threadpool

from server.base.errors import Invalid
from server.base.http import client_address
from server.course.dependencies import CourseOf
from server.identity.dependencies import BrowserAccount
from server.steps.routes import StepsDep
from server.steps.schemas import MAX_AFTER, MAX_CALL, MAX_STDIN, CallBody, TraceOut
from server.steps.writing import format_traced_value
from server.web.forms import FormFields
from server.web.rendering import render_page
from server.web.views import build_module_link, exercise_href, find_exercise

router = APIRouter(include_in_schema=False)

TOO_LONG = f"Un appel fait au plus {MAX_CALL} caractères."
STDIN_TOO_LONG = f"L’entrée standard fait au plus {MAX_STDIN} caractères."
AFTER_TOO_LONG = f"Le petit programme fait au plus {MAX_AFTER} caractères."


@router.post("/{module:module}/exercices/{slug}/executer")
async def run_typed_call(
    request: Request,
    module: str,
    slug: str,
    account: BrowserAccount,
    course: CourseOf,
    steps: StepsDep,
    fields: FormFields,
) -> Response:
    """Run a typed call of the code of the form, or the code alone where there is none, with its standard input."""
    exercise = find_exercise(course, module, slug)
    code, call, stdin, after = (
        str(fields.get(name, "")).replace("\r\n", "\n") for name in ("code", "call", "stdin", "after")
    )
    page: dict[str, Any] = {
        "module": build_module_link(course.modules[exercise.module]),
        "exercise_title": exercise.title,
        "exercise_href": exercise_href(exercise),
        "here": f"{exercise_href(exercise)}/executer",
        "action": f"{exercise_href(exercise)}/soumissions",
        "code": code,
        "call": call,
        "stdin": stdin,
        "after": after,
        "is_class": all(wanted.is_class for wanted in exercise.functions),
        "is_program": any(wanted.is_program for wanted in exercise.functions),
        "refusal": "",
        "trace": None,
        "value": "",
    }
    try:
        if len(call) > MAX_CALL:
            raise Invalid(TOO_LONG)
        if len(stdin) > MAX_STDIN:
            raise Invalid(STDIN_TOO_LONG)
        if len(after) > MAX_AFTER:
            raise Invalid(AFTER_TOO_LONG)
        body = CallBody(code=code, call=call, plain=True, stdin=stdin, after=after)
        answer = await steps.trace_call(account, exercise.id, body, client_address(request))
    except Invalid as refused:
        page["refusal"] = refused.detail
    else:
        trace = TraceOut.model_validate_json(answer)
        page |= {"trace": trace, "value": "" if trace.end.value is None else format_traced_value(trace.end.value)}
    return await run_in_threadpool(render_page, request, "own_run.html", account, page=page)
