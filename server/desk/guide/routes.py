"""Pages of the guide for teachers."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from server.base.errors import NotFound
from server.desk.guide.chapters import PREFIX, TITLES, load_chapters
from server.identity.dependencies import OptionalAccount
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

NO_SUCH_CHAPTER = "Le guide n’a pas ce chapitre."


@router.get(PREFIX)
def show_guide(request: Request, account: OptionalAccount) -> HTMLResponse:
    return _render_chapter(request, account, "")


@router.get(f"{PREFIX}/{{chapter}}")
def show_chapter(request: Request, account: OptionalAccount, chapter: str) -> HTMLResponse:
    return _render_chapter(request, account, chapter)


def _render_chapter(request: Request, account: OptionalAccount, slug: str) -> HTMLResponse:
    chapter = load_chapters().get(slug)
    if chapter is None:
        raise NotFound(NO_SUCH_CHAPTER)
    return render_page(request, "guide.html", account, chapter=chapter, titles=TITLES, prefix=PREFIX)
