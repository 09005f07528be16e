"""The addresses of a module's archive: the page that gives it, and the file, which touches no database."""

from __future__ import annotations

from http import HTTPStatus
from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Depends, Request
from fastapi.responses import FileResponse, HTMLResponse, RedirectResponse
from starlette.concurrency import run_in_threadpool

from server.base.app_services import app_service
from server.offline.schemas import OfflinePage
from server.offline.service import ArchiveInProgress, OfflineArchives
from server.offline.site import archive_folder_name
from server.web.dependencies import CurrentReader
from server.web.rendering import render_page
from server.web.schemas import ModuleLink
from server.web.views import build_module_link

ArchivesOf = Annotated[OfflineArchives, Depends(app_service(OfflineArchives))]
REFRESH = 4  # seconds

router = APIRouter(include_in_schema=False)


@router.get("/{module:module}/hors-ligne")
async def show_offline_page(request: Request, archives: ArchivesOf, reader: CurrentReader, module: str) -> HTMLResponse:
    course_module = archives.module(module)
    view = build_offline_page(build_module_link(course_module), await archives.look(course_module))
    headers = {"Refresh": str(REFRESH)} if view.state == "making" else {}
    account = await run_in_threadpool(reader.who)
    return await run_in_threadpool(render_page, request, "offline/page.html", account, headers=headers, page=view)


@router.post("/{module:module}/hors-ligne")
async def prepare_archive(archives: ArchivesOf, module: str) -> RedirectResponse:
    await archives.prepare(archives.module(module))
    return RedirectResponse(f"/{module}/hors-ligne", HTTPStatus.SEE_OTHER)


@router.get("/{module:module}/hors-ligne.zip")
async def download_archive(archives: ArchivesOf, module: str) -> FileResponse:
    course_module = archives.module(module)
    path = await archives.file(course_module)
    name = f"{archive_folder_name(course_module)}.zip"
    return FileResponse(path, media_type="application/zip", filename=name, headers={"Cache-Control": "no-cache"})


def build_offline_page(module: ModuleLink, found: Path | ArchiveInProgress | None) -> OfflinePage:
    if isinstance(found, Path):
        return OfflinePage(module, "ready", size=format_size_in_megabytes(found))
    if found is None:
        return OfflinePage(module, "wanted")
    return OfflinePage(module, "failed" if found.failed else "making", done=found.done, total=found.total)


def format_size_in_megabytes(path: Path) -> str:
    """« 3,4 Mo »."""
    return f"{max(path.stat().st_size / 1e6, 0.1):.1f}\u00a0Mo".replace(".", ",")
