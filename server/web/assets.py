"""Style sheets, scripts and fonts: the built ones, or the sources as they are where nothing was built."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from starlette.datastructures import Headers
from starlette.responses import FileResponse, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

from server.base.http import accepted_encodings

log = logging.getLogger(__name__)

SERVER = Path(__file__).parents[1]
BUILT = SERVER / "static"
SOURCES = SERVER / "frontend" / "src"
STAMP = "stamp.txt"
PREFIX = "/static"
FOREVER = "public, max-age=31536000, immutable"
#: The encodings of what was compressed when it was built, the smallest first: what follows the file's name.
PACKED = {"br": ".br", "gzip": ".gz"}


class _PrecompressedStaticFiles(StaticFiles):
    """Files of which some stand compressed beside themselves."""

    def file_response(
        self, full_path: str | os.PathLike[str], stat_result: os.stat_result, scope: Scope, status_code: int = 200
    ) -> Response:
        for encoding in accepted_precompressed_encodings(Headers(scope=scope).get("accept-encoding", "")):
            packed = f"{os.fspath(full_path)}{PACKED[encoding]}"
            if os.path.isfile(packed):
                answer = super().file_response(packed, os.stat(packed), scope, status_code)
                answer.headers["Content-Type"] = FileResponse(full_path).headers["Content-Type"]
                answer.headers["Content-Encoding"] = encoding
                break
        else:
            answer = super().file_response(full_path, stat_result, scope, status_code)
        answer.headers["Vary"] = "Accept-Encoding"
        return answer


def accepted_precompressed_encodings(header: str) -> Iterator[str]:
    """Return our encodings that the browser accepts, in our order."""
    taken = accepted_encodings(header)
    return (encoding for encoding in PACKED if encoding in taken)


@lru_cache(maxsize=1)
def is_frontend_built() -> bool:
    """False where npm was out of reach at install time: a plain text area, and formulas as TeX."""
    built = (BUILT / STAMP).is_file()
    if not built:
        log.warning("The front end is not built: plain text area and formulas as TeX (install again with npm in reach)")
    return built


@lru_cache(maxsize=1)
def frontend_version_tag() -> str:
    """Return the version tag in the addresses of static files."""
    return (BUILT / STAMP).read_text(encoding="utf-8")[:12] if is_frontend_built() else "source"


def static_url(name: str) -> str:
    """The address of a static file, which changes with its content: it may be cached for ever."""
    return f"{static_url_prefix()}/{name}"


def static_url_prefix() -> str:
    """Return the prefix of the addresses of static files."""
    return f"{PREFIX}/{frontend_version_tag()}"


def static_folder() -> Path:
    """Where static files are."""
    return BUILT if is_frontend_built() else SOURCES


@lru_cache(maxsize=1)
def _static_files_app() -> StaticFiles:
    return _PrecompressedStaticFiles(directory=static_folder())


async def serve_static(scope: Scope, version: str, name: str) -> Response:
    """The answer to a request for a static file. Raises 404 (HTTPException) where there is none.

    A page that was opened before an update asks for the old version: it gets the new file, and does not keep it.
    """
    answer = await _static_files_app().get_response(name, scope)
    current = is_frontend_built() and version == frontend_version_tag()
    answer.headers["Cache-Control"] = FOREVER if current else "no-cache"
    return answer
