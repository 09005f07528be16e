"""How the routes' errors are documented in the OpenAPI document."""

from typing import Any

from fastapi import FastAPI

from server.api.schemas import ProblemOut
from server.base import root_path

PROBLEM_SCHEMA = "#/components/schemas/ProblemOut"
MEANINGS = {
    400: "The request cannot be read.",
    401: "The bearer token is missing, unknown or revoked.",
    403: "A right is missing; `detail` names it, in French.",
    404: "No such thing, or it is someone else's.",
    409: "What is there does not allow it.",
    413: "The code, or the request, is too large.",
    422: "The data is refused; `errors` tells where.",
    429: "Too many submissions, or tries; `Retry-After` tells when to come back.",
    503: "Too many people want the same thing, or the database is away; `Retry-After` says when to come back.",
}
Responses = dict[int | str, dict[str, Any]]


def problem_responses(*statuses: int) -> Responses:
    """The `responses` of a route that may answer with these problem documents."""
    content = {"application/problem+json": {"schema": {"$ref": PROBLEM_SCHEMA}}}
    return {status: {"description": MEANINGS[status], "content": content} for status in statuses}


def event_stream_response(description: str, name: str) -> dict[str, Any]:
    """Server-sent events of one name, whose data is JSON."""
    data = {"type": "string", "contentMediaType": "application/json"}
    schema = {"type": "object", "properties": {"event": {"const": name}, "data": data}, "required": ["event", "data"]}
    return {"description": description, "content": {"text/event-stream": {"schema": schema}}}


def text_response(description: str, media_type: str) -> dict[str, Any]:
    return {"description": description, "content": {media_type: {"schema": {"type": "string"}}}}


def _complete_openapi(document: dict[str, Any]) -> dict[str, Any]:
    """Adds the problem document's schema, and puts it wherever FastAPI announces its own validation error; and where
    the paths begin, when that is not the site's root."""
    schemas = document.setdefault("components", {}).setdefault("schemas", {})
    schema = ProblemOut.model_json_schema(ref_template="#/components/schemas/{model}")
    schemas.update(schema.pop("$defs", {}))
    schemas["ProblemOut"] = schema
    for path in document["paths"].values():
        for operation in path.values():
            if "422" in operation["responses"]:
                operation["responses"].update({"422": problem_responses(422)[422]})
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    if root_path.root_path():
        document["servers"] = [{"url": root_path.root_path()}]
    return document


def install_openapi(app: FastAPI) -> None:
    """Has the application describe itself so."""
    original = app.openapi

    def openapi() -> dict[str, Any]:
        if not app.openapi_schema:
            app.openapi_schema = _complete_openapi(original())
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]
