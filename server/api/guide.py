"""The page that documents the HTTP interface, made from its OpenAPI document: it says what that says, in French."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from server.api.words import ANYTHING, PARAMETERS, ROUTES, STATUSES, TYPES
from server.base.root_path import service_url
from server.course import Course
from server.course.dependencies import CourseOf
from server.identity.dependencies import OptionalAccount
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

Json = Mapping[str, Any]
DEEPEST = 4  # objects inside objects of an answer that are spelt out
INDENT = "  "
SHOWN_EXERCISE = "l20/poses"  # in the examples, where the course has no exercise with code


@dataclass(frozen=True)
class ParameterView:
    name: str
    kind: str
    optional: bool
    words: str


@dataclass(frozen=True)
class AnswerView:
    status: str
    words: str


@dataclass(frozen=True)
class RouteView:
    """One route: `command` is an example in a shell, `answer` the shape of what comes back where that is JSON."""

    id: str
    method: str
    path: str
    words: str
    parameters: tuple[ParameterView, ...]
    body: tuple[ParameterView, ...]
    answers: tuple[AnswerView, ...]
    command: str
    answer: str


@dataclass(frozen=True)
class GuidePage:
    address: str
    exercise: str
    routes: tuple[RouteView, ...]


@router.get("/docs")
def guide(request: Request, account: OptionalAccount, course: CourseOf) -> HTMLResponse:
    address = service_url(request)
    return render_page(request, "docs.html", account, page=build_guide_page(request.app.openapi(), course, address))


def build_guide_page(document: Json, course: Course, address: str) -> GuidePage:
    shown = next((exercise.id for exercise in course.exercises.values() if exercise.answers is None), SHOWN_EXERCISE)
    return GuidePage(address, shown, tuple(_iter_routes(OpenApiGuide(document, shown, address))))


@dataclass(frozen=True)
class OpenApiGuide:
    """An OpenAPI document, and what its examples speak of."""

    document: Json
    exercise: str
    address: str

    def resolved(self, schema: Json) -> Json:
        while "$ref" in schema:
            schema = self.document["components"]["schemas"][schema["$ref"].rpartition("/")[2]]
        return schema

    def given(self, schema: Json) -> Json:
        """What stands in the place of a value that may be null, where it is not."""
        schema = self.resolved(schema)
        choices = [option for option in schema.get("anyOf", ()) if option.get("type") != "null"]
        return self.resolved(choices[0]) if len(choices) == 1 else schema


def _iter_routes(guide: OpenApiGuide) -> Iterator[RouteView]:
    for path, operations in guide.document["paths"].items():
        for method, operation in operations.items():
            yield _build_route_view(guide, path, method, operation)


def _build_route_view(guide: OpenApiGuide, path: str, method: str, operation: Json) -> RouteView:
    contents = operation.get("requestBody", {}).get("content", {})
    content = contents.get("application/json")
    body = guide.given(content["schema"]) if content else None
    file = None if content else next(iter(contents), None)
    answers = operation["responses"]
    return RouteView(
        id=operation["operationId"],
        method=method.upper(),
        path=path,
        words=ROUTES.get((method, path)) or str(operation.get("description", "")),
        parameters=tuple(_build_parameter_view(guide, parameter) for parameter in operation.get("parameters", ())),
        body=tuple(_iter_fields(guide, body)) if body else (),
        answers=tuple(AnswerView(status, _describe_answer(status, answers[status])) for status in sorted(answers)),
        command=_build_example_command(guide, path, method, body, file),
        answer=_format_success_shape(guide, answers),
    )


def _describe_answer(status: str, answer: Json) -> str:
    return STATUSES.get(status) or str(answer["description"])


def _build_parameter_view(guide: OpenApiGuide, parameter: Json) -> ParameterView:
    name = parameter["name"]
    return ParameterView(
        name,
        describe_type(guide, parameter["schema"]),
        not parameter.get("required"),
        _describe_parameter(name, parameter),
    )


def _describe_parameter(name: str, field: Json) -> str:
    return PARAMETERS.get(name) or str(field.get("description", ""))


def _iter_fields(guide: OpenApiGuide, schema: Json) -> Iterator[ParameterView]:
    for name, field in schema["properties"].items():
        yield ParameterView(
            name, describe_type(guide, field), name not in schema.get("required", ()), _describe_parameter(name, field)
        )


def describe_type(guide: OpenApiGuide, schema: Json) -> str:
    """What a value is, in a few words."""
    schema = guide.resolved(schema)
    if "anyOf" in schema:
        return " | ".join(dict.fromkeys(describe_type(guide, option) for option in schema["anyOf"]))
    values = [schema["const"]] if "const" in schema else schema.get("enum")
    if values:
        return " | ".join(json.dumps(value, ensure_ascii=False) for value in values)
    if schema.get("type") == "array":
        return f"[{describe_type(guide, schema['items'])}, …]"
    if schema.get("type") == "object":
        return "{…}"
    return TYPES.get(schema.get("format", ""), "") or TYPES.get(schema.get("type", ""), ANYTHING)


def format_json_shape(guide: OpenApiGuide, schema: Json, margin: str = "", depth: int = 0) -> str:
    """A JSON value as it is written, with what each part of it is in the place of the part."""
    schema, value = guide.resolved(schema), guide.given(schema)
    deeper = margin + INDENT
    if value is not schema:
        return f"{format_json_shape(guide, value, margin, depth)} | null"
    if schema.get("type") == "array":
        return f"[{format_json_shape(guide, schema['items'], margin, depth)}, …]"
    properties = schema.get("properties")
    if not properties or depth >= DEEPEST:
        return describe_type(guide, schema)
    lines = [
        f'{deeper}"{name}": {format_json_shape(guide, field, deeper, depth + 1)}' for name, field in properties.items()
    ]
    return "{\n" + ",\n".join(lines) + f"\n{margin}}}"


def _format_success_shape(guide: OpenApiGuide, answers: Json) -> str:
    contents = [answers[status].get("content", {}) for status in sorted(answers) if status.startswith("2")]
    schemas = [content["application/json"]["schema"] for content in contents if "application/json" in content]
    return format_json_shape(guide, schemas[0]) if schemas else ""


def _build_example_command(guide: OpenApiGuide, path: str, method: str, body: Json | None, file: str | None) -> str:
    module, _, slug = guide.exercise.partition("/")
    values = {
        "module": module,
        "slug": slug,
        "submission_id": "$ID",
        "name": "$FIGURE",
        "class_id": "$CLASS",
        "thread_id": "$THREAD",
        "student": "$STUDENT",
        "aid": "$ASSIGNMENT",
        "eid": "$EXCEPTION",
    }
    for name, value in values.items():
        path = path.replace(f"{{{name}}}", value)
    lines = ['curl -H "Authorization: Bearer $BALISE_TOKEN"']
    if method not in {"get", "post"}:
        lines.append(f"-X {method.upper()}")
    if body is not None:
        example = body.get("examples", [dict.fromkeys(body["properties"], "…")])[0]
        lines += ["-H 'Content-Type: application/json'", f"-d {shlex.quote(json.dumps(example, ensure_ascii=False))}"]
    if file is not None:
        lines += [f"-H 'Content-Type: {file}'", "--data-binary @liste.csv"]
    return " \\\n  ".join([*lines, f'"{guide.address}{path}"'])
