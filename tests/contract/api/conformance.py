"""Requests generated from the OpenAPI document, and the checks of what comes back."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import schemathesis
from hypothesis import HealthCheck, given
from hypothesis import settings as hypothesis_settings
from hypothesis.errors import Unsatisfiable
from schemathesis import GenerationMode
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_headers_conformance,
    response_schema_conformance,
    status_code_conformance,
)

CONFORMANCE = (
    not_a_server_error, status_code_conformance, content_type_conformance, response_schema_conformance,
    response_headers_conformance,
)  # fmt: skip


def operations(document: str) -> Iterator[Any]:
    for result in schemathesis.openapi.from_url(document).get_all_operations():
        yield result.ok()


def conforms(operation: Any, mode: str, path: dict[str, str], headers: dict[str, str], examples: int) -> None:
    """Answers to generated requests, fitting (positive) or not (negative), are those that the document announces."""

    @given(case=operation.as_strategy(generation_mode=GenerationMode(mode)))
    @hypothesis_settings(max_examples=examples, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    def check(case: Any) -> None:
        for name in case.path_parameters.keys() & path.keys():
            case.path_parameters[name] = path[name]
        case.call_and_validate(headers=headers, checks=list(CONFORMANCE), timeout=300)

    try:
        check()
    except Unsatisfiable:
        assert mode == "negative", "nothing can be wrong in a request that holds nothing"
