"""The pages to read over HTTP: what they hold, what they refuse, what they never load."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import anyio.to_thread
import pytest

from server.base.app_services import app_service
from server.base.settings import Settings
from server.course.lengths import duration_in_words
from server.database import Database
from server.figures.service import FigureService
from server.reading.service import dictionary_sort_key
from tests.support.client import TestClient
from tests.support.quick import migrated, standing_app
from tests.support.small_course import CourseFolder
from tests.support.small_site import PAGE, SmallSite, verdict
from tests.support.texts import with_texts

READ = "/m9/lire/depart"


@pytest.fixture
def small_site(course_folder: CourseFolder, tmp_path: Path) -> Iterator[SmallSite]:
    settings = Settings(data_dir=tmp_path / "data", workers=0)
    database = migrated(settings)
    app = standing_app(settings, with_texts(course_folder.load()))
    with TestClient(app) as client:
        yield SmallSite(client, database)
    database.close()


def test_a_page_shows_its_text_its_objectives_and_its_contents(small_site: SmallSite) -> None:
    page = small_site.get(READ)
    for text in (
        '<h1 id="titre">Titre de depart</h1>',
        "Résumé de depart.",
        "1\u00a0h\u00a030",
        "Lire &lt;vite&gt; &amp; bien.",
        '<p class="block-title"><span class="block-label">Théorème 1</span> Le premier</p>',
        '<a href="#s-un">Un <em>début</em></a>',
        '<a href="#s-detail">Un détail</a>',
    ):
        assert text in page
    assert page.count('href="#s-deux"') == 2, "at the side, and folded above the text"


def test_headings_go_down_one_step_at_a_time(small_site: SmallSite) -> None:
    for path in (READ, "/m9", "/m9/glossaire", "/m9/recherche?q=pose"):
        levels = [int(one) for one in re.findall(r"<h([1-6])\b", small_site.get(path))]
        assert levels[0] == 1
        assert levels.count(1) == 1
        assert all(after - before <= 1 for before, after in pairwise(levels)), (path, levels)


def test_the_words_of_a_page_bring_their_definition_once(small_site: SmallSite) -> None:
    page = small_site.get(READ)
    assert page.count('data-definition="pose"') == 1
    assert "Le sens de <em>pose</em>." in page
    assert 'data-definition="etat"' not in page


def test_pages_follow_each_other_as_the_course_lists_them(small_site: SmallSite) -> None:
    seen, path = [], READ
    while path:
        seen.append(path.rsplit("/", 1)[1])
        following = re.search(r'rel="next" href="([^"]+)"', small_site.get(path))
        path = following[1] if following else ""
    assert seen == ["depart", "arrivee", "memoire", "recherche"]
    assert 'rel="prev"' not in small_site.get(READ)
    assert f'rel="prev" href="{READ}"' in small_site.get("/m9/lire/arrivee")


def test_exercises_follow_their_seance_with_ones_own_state(small_site: SmallSite) -> None:
    assert "À faire" in small_site.get(READ)
    assert "À vous de jouer" not in small_site.get("/m9/lire/arrivee")
    small_site.attempt("x = 1", verdict("wrong_answer", 12.5))
    assert "12,5 / 20" in small_site.get(READ)
    small_site.attempt("x = 2", verdict("ok", 20.0))
    page = small_site.get(READ)
    assert "Réussi" in page
    assert f'href="{PAGE}"' in page
    assert "À faire" in small_site.another().get(READ)


def test_the_module_tells_who_comes_back_where_to_go_on(small_site: SmallSite) -> None:
    assert "Reprendre l’exercice" not in small_site.get("/m9")
    small_site.attempt("x = 1", verdict("wrong_answer", 12.5))
    assert f'<a href="{PAGE}">Reprendre l’exercice' in small_site.get("/m9")
    small_site.attempt("x = 2", verdict("ok", 20.0))
    assert '<a href="/m9/exercices/b">Exercice suivant' in small_site.get("/m9")


def test_an_exercise_leads_back_to_its_lesson(small_site: SmallSite) -> None:
    page = small_site.get(PAGE)
    assert f'<a href="{READ}">Séance 1</a>' in page
    assert f'<a href="{READ}">Relire : Séance 1</a>' in page, "after the verdict too"
    assert "/lire/" not in small_site.get("/m9/exercices/b")


def test_a_page_that_has_not_changed_is_not_sent_again(small_site: SmallSite) -> None:
    tag = small_site.client.get(READ).headers["etag"]
    again = small_site.client.get(READ, headers={"If-None-Match": tag})
    assert (again.status_code, again.content) == (304, b"")
    small_site.attempt("x = 1", verdict("ok", 20.0))
    assert small_site.client.get(READ, headers={"If-None-Match": tag}).status_code == 200


OWN, PACKED = "private, no-cache", "Accept-Encoding"
#: Of each kind of answer: how long it may be kept, what it depends on beside its address, and whether it has a tag.
KEPT = {
    **dict.fromkeys(("/", "/m9", READ, "/m9/glossaire", PAGE, f"{PAGE}/essais", "{attempt}"), (OWN, PACKED, True)),
    "/m9/recherche?q=pose": (OWN, PACKED, True),
    "/m9/lire/rien": (OWN, PACKED, False),
    "{attempt}/verdict": ("private, no-store", PACKED, False),
    "{attempt}/evenements": ("no-store", None, False),
    "/m9/fichiers/rien.zip": (OWN, PACKED, False),
    "/static/old/img/favicon.svg": ("no-cache", PACKED, True),
}


def test_what_may_be_kept_of_each_answer(small_site: SmallSite) -> None:
    attempt = small_site.attempt("x = 1", verdict())
    found = {path: small_site.client.get(path.format(attempt=attempt)).headers for path in KEPT}
    told = {path: (one.get("cache-control"), one.get("vary"), "etag" in one) for path, one in found.items()}
    assert told == KEPT


def test_nobody_is_sent_what_another_was(small_site: SmallSite) -> None:
    """Whoever shares a browser, or knows the tag of somebody's page, is shown their own."""
    attempt = small_site.attempt("x = 'à moi'", verdict())
    form = {"name": "Ada Lovelace", "login": "ada", "password": "une phrase assez longue"}
    small_site.client.post("/inscription", data=form)
    other = small_site.another()
    for path in ("/", "/m9", READ, PAGE, f"{PAGE}/essais"):
        mine = small_site.client.get(path)
        theirs = other.client.get(path, headers={"If-None-Match": mine.headers["etag"]})
        assert "Ada Lovelace" in mine.text
        assert theirs.status_code == 200
        assert "Ada Lovelace" not in theirs.text
        assert "à moi" not in theirs.text
        assert small_site.client.get(path, headers={"If-None-Match": mine.headers["etag"]}).status_code == 304
    assert other.client.get(attempt).status_code == 404


@pytest.mark.parametrize(("near", "crossings"), [(True, 1), (False, 2)], ids=["a file", "a server of databases"])
def test_a_page_is_made_in_one_thread(
    small_site: SmallSite, monkeypatch: pytest.MonkeyPatch, near: bool, crossings: int
) -> None:
    """Crossing to a thread costs more than a statement; a connection to another machine is given back in one too."""
    small_site.attempt("x = 1", verdict())
    crossed: list[object] = []
    run = anyio.to_thread.run_sync

    async def counted(function: Any, *arguments: Any, **options: Any) -> Any:
        crossed.append(function)
        return await run(function, *arguments, **options)

    for path in ("/", READ, PAGE):
        small_site.client.get(path)
    for module in ("anyio.to_thread", "server.database.dependencies"):
        monkeypatch.setattr(f"{module}.run_sync", counted)
    monkeypatch.setattr(Database, "is_local_file", near)
    for path in ("/", READ, PAGE):
        crossed.clear()
        assert small_site.client.get(path).status_code == 200
        assert len(crossed) == crossings, (path, crossed)


def test_a_lesson_is_the_same_however_it_travels(small_site: SmallSite) -> None:
    plain = small_site.client.get(READ, headers={"Accept-Encoding": "identity"})
    packed = small_site.client.get(READ, headers={"Accept-Encoding": "gzip"})
    assert [one.headers.get("content-encoding") for one in (plain, packed)] == [None, "gzip"]
    assert plain.text == packed.text
    assert plain.headers["etag"] == packed.headers["etag"]
    assert "<!--" not in plain.text


@pytest.mark.parametrize("refused", ["gzip;q=0", "br, gzip ; q=0.000", "identity, GZIP;Q=0"])
def test_an_encoding_that_is_refused_is_not_used(small_site: SmallSite, refused: str) -> None:
    for path, taken in ((READ, refused), (READ, "gzip;q=0.1"), ("/m9/recherche?q=un", refused)):
        answer = small_site.client.get(path, headers={"Accept-Encoding": taken})
        packed = "gzip" if taken != refused else None
        assert (answer.headers.get("content-encoding"), answer.headers["vary"]) == (packed, "Accept-Encoding")
        assert "<html" in answer.text


def test_a_drawing_that_one_has_is_not_sent_again(small_site: SmallSite) -> None:
    class Drawn:
        async def draw_lesson_figure(self, *_: str) -> bytes:
            return b"<svg/>"

    small_site.client.app.dependency_overrides[app_service(FigureService)] = Drawn  # type: ignore[attr-defined]
    path = "/m9/figures/dessin.svg?theme=dark"
    first = small_site.client.get(path)
    assert (first.content, first.headers["content-type"]) == (b"<svg/>", "image/svg+xml")
    assert "default-src 'none'" in first.headers["content-security-policy"]
    again = small_site.client.get(path, headers={"If-None-Match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


def test_pages_are_compressed_and_streams_are_not(small_site: SmallSite) -> None:
    asked = {"Accept-Encoding": "gzip"}
    assert small_site.client.get(READ, headers=asked).headers["content-encoding"] == "gzip"
    href = small_site.attempt("x = 1", verdict())
    with small_site.client.stream("GET", f"{href}/evenements", headers=asked) as answer:
        assert "content-encoding" not in answer.headers


def test_the_module_opens_on_its_course(small_site: SmallSite) -> None:
    page = small_site.get("/m9")
    assert f'href="{READ}" data-start>Commencer' in page
    titles = ["Séances", "Autres exercices", "Fiches", "Annexes"]
    places = [page.index(f">{title}</h2>") for title in titles]
    assert places == sorted(places)
    assert "Glossaire (3 mots)" in page
    assert 'data-read-of="depart" data-parts="2"' in page
    assert "/m9/figures/dessin.svg?theme=dark" in page


def test_a_module_without_texts_lists_its_exercises(course_folder: CourseFolder, tmp_path: Path) -> None:
    settings = Settings(data_dir=tmp_path / "data", workers=0)
    migrated(settings).close()
    with TestClient(standing_app(settings, course_folder.load())) as client:
        page = client.get("/m9").text
        assert ">Exercices</h2>" in page
        for absent in ("Commencer", "Séances", "head-search", "glossaire"):
            assert absent not in page
        assert client.get("/m9/glossaire").status_code == 404


def test_the_glossary_goes_by_letters_without_regard_to_accents(small_site: SmallSite) -> None:
    page = small_site.get("/m9/glossaire")
    assert re.findall(r'<h2 id="lettre-(.)">', page) == ["a", "e", "p"]
    assert '<div id="t-etat"' in page
    assert page.count(f'href="{READ}"') == 2, "no link from a word whose page does not exist"


def test_a_search_marks_what_it_found_and_runs_nothing(small_site: SmallSite) -> None:
    page = small_site.get("/m9/recherche?q=particules")
    assert 'value="particules"' in page
    assert f'<a href="{READ}#s-deux">Deux</a>' in page
    assert "<mark>particules</mark>" in page
    assert "&lt;script&gt;alert(1)" in page
    assert "<script>alert" not in page
    assert "head-search" not in page, "one field is enough"


@pytest.mark.parametrize("query", ["zygomatique", "<zut onload=zut>", '" OR *', "%00%02"])
def test_a_search_that_finds_nothing_says_so_and_helps(small_site: SmallSite, query: str) -> None:
    page = small_site.get(f"/m9/recherche?q={query}")
    assert "<zut onload=zut>" not in page
    assert "Rien ne parle de" in page
    assert '<a href="/m9/glossaire">glossaire</a>' in page
    assert "recherche?q=pose" in page


def test_an_empty_search_waits_for_a_word(small_site: SmallSite) -> None:
    for path in ("/m9/recherche", "/m9/recherche?q=%20%20"):
        page = small_site.get(path)
        assert "Un mot du cours" in page
        assert "Rien ne parle" not in page
    assert 'action="/m9/recherche"' in small_site.get(READ)
    assert "head-search" in small_site.get("/m9/lire/recherche"), "a page may well be called so"


@pytest.mark.parametrize("path", ["/m9/lire/rien", "/m8/lire/depart", "/m9/figures/rien.svg", "/m8/glossaire"])
def test_what_does_not_exist_is_told_in_french(small_site: SmallSite, path: str) -> None:
    assert "existe pas" in small_site.get(path, status=404)


def test_nothing_comes_from_elsewhere(small_site: SmallSite) -> None:
    for path in ("/m9", READ, "/m9/glossaire", "/m9/recherche?q=pose"):
        addresses = re.findall(r'(?:href|src|srcset|action)="([^"]*)"', small_site.get(path))
        assert addresses
        assert not [one for one in addresses if not one.startswith(("/", "#", "?"))]


@pytest.mark.parametrize(
    ("minutes", "words"), [(0, ""), (45, "45\u00a0min"), (60, "1\u00a0h"), (67, "1\u00a0h\u00a010"), (240, "4\u00a0h")]
)
def test_lengths_in_words(minutes: int, words: str) -> None:
    assert duration_in_words(minutes) == words


def test_words_are_sorted_as_in_a_dictionary() -> None:
    words = ["SLAM par graphe", "état", "scan matching", "A*", "étape", "Nav2"]
    assert sorted(words, key=dictionary_sort_key) == ["A*", "étape", "état", "Nav2", "scan matching", "SLAM par graphe"]
