"""A module's pages and glossary as they are loaded: front matter, order, numbers over the module, what is refused."""

from __future__ import annotations

import pytest

from server.course.kinds import KINDS
from server.course.models import Module
from tests.support.small_course import EXERCISE, CourseFolder
from tests.support.texts_on_disk import FIGURES, FRONT, GLOSSARY, page, problems, write_page

FULL = """+++
title = "Localiser : où suis-je ?"
order = 10
label = "Séance 1"
minutes = 120
summary = "Une phrase."
objectives = ["Dire où l'on est.", "Le prouver."]
+++
Du texte.
"""
THEOREM = "::: theoreme #{0}\nA\n:::\n\n$$\na\n$$ (eq-{0})\n\nVoir [](#{1}) et [](#eq-{1}).\n"
WIDE = "\u00a0"


def module(course_folder: CourseFolder) -> Module:
    return course_folder.load(render=False).modules["m9"]


def test_front_matter(course_folder: CourseFolder) -> None:
    course_folder.write("curriculum/m9/seances/localiser.md", FULL)
    assert problems(course_folder) == []
    lesson = page(course_folder, "localiser")
    assert (lesson.module, lesson.slug, lesson.kind.name) == ("m9", "localiser", "seance")
    assert (lesson.title, lesson.label, lesson.summary) == ("Localiser : où suis-je ?", "Séance 1", "Une phrase.")
    assert (lesson.order, lesson.minutes) == (10, 120)
    assert lesson.objectives == ("Dire où l'on est.", "Le prouver.")
    assert lesson.html == "<p>Du texte.</p>\n"
    assert (lesson.headings, lesson.figures, lesson.replays, lesson.cells) == ((), (), (), ())


BAD_FRONT = {
    "unknown key": (FULL.replace("minutes", "minute"), 5, "champ inconnu : « minute »"),
    "missing key": (FULL.replace('label = "Séance 1"\n', ""), 2, "champ manquant : « label »"),
    "wrong type": (FULL.replace("= 120", '= "120"'), 5, "nombre entier"),
    "negative length": (FULL.replace("= 120", "= -1"), 5, "minutes"),
    "TOML that does not parse": (FULL.replace("= 10\n", "=\n"), 3, "TOML mal formé"),
    "formula in an objective": (FULL.replace("Le prouver", "Calculer $x$"), 7, "ni formule ni code"),
    "code in the title": (FULL.replace("Localiser", "`lidar`"), 2, "ni formule ni code"),
    "no front matter": ("Du texte.\n", 1, "commence par une ligne « +++ »"),
    "front matter left open": ('+++\ntitle = "A"\n', 1, "qui ferme l’en-tête"),
    "not UTF-8": ("+++\ntitre\xe9".encode("latin-1"), 2, "UTF-8"),
}


@pytest.mark.parametrize(("content", "line", "message"), BAD_FRONT.values(), ids=BAD_FRONT.keys())
def test_bad_front_matter_keeps_that_page_out(
    course_folder: CourseFolder, content: str | bytes, line: int, message: str
) -> None:
    path = course_folder.write("curriculum/m9/seances/localiser.md", "")
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    write_page(course_folder, "une", "Du texte.\n")
    for render in (False, True):
        (problem,) = problems(course_folder, render=render)
        assert (problem.path, problem.line) == (path, line)
        assert message in problem.message
    assert [one.slug for one in module(course_folder).lessons] == ["une"]


def test_pages_come_in_the_order_of_reading(course_folder: CourseFolder) -> None:
    for folder, kind in (
        ("annexes", "annexe"), ("cours", "cours"), ("defis", "defi"), ("fiches", "fiche"), ("seances", "seance"),
        ("tp", "tp"),
    ):  # fmt: skip
        write_page(course_folder, f"{kind}-b", "A\n", folder=folder, order=20)
        write_page(course_folder, f"{kind}-a", "A\n", folder=folder, order=30)
        write_page(course_folder, f"{kind}-c", "A\n", folder=folder, order=20)
    course_folder.write("curriculum/m9/COUVERTURE.md", "Pas une page.")
    course_folder.write("curriculum/m9/seances/_brouillon.md", "Pas une page.")
    assert problems(course_folder) == []
    kinds = ("fiche", "seance", "cours", "tp", "defi", "annexe")
    assert [one.slug for one in module(course_folder).lessons] == [f"{kind}-{end}" for kind in kinds for end in "bca"]


def test_numbers_run_over_the_whole_module(course_folder: CourseFolder) -> None:
    write_page(course_folder, "deux", THEOREM.format("b", "a"), folder="seances")
    write_page(course_folder, "une", THEOREM.format("a", "b"), folder="fiches")
    write_page(course_folder, "zero", THEOREM.format("c", "c"), folder="fiches", order=5)
    assert problems(course_folder) == []
    une, deux = page(course_folder, "une").html, page(course_folder, "deux").html
    assert f"Théorème{WIDE}2" in une
    assert f'<a href="/m9/lire/deux#b">théorème{WIDE}3</a> et <a href="/m9/lire/deux#eq-b">(3)</a>' in une
    assert f'<a href="/m9/lire/une#a">théorème{WIDE}2</a> et <a href="/m9/lire/une#eq-a">(2)</a>' in deux


def test_a_label_that_another_page_has(course_folder: CourseFolder) -> None:
    write_page(course_folder, "une", "::: theoreme #a\nA\n:::\n")
    write_page(course_folder, "deux", "A\n\n::: piege #a\nA\n:::\n", folder="tp")
    (problem,) = problems(course_folder, render=False, check=True)
    assert (problem.path.name, problem.line) == ("deux.md", FRONT.count("\n") + 3)
    assert problem.message == "étiquette déjà prise par la page « une » : « #a »"


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("seances/Été.md", "nom de page"),
        ("seances/glossaire.md", "nom de page"),
        ("tp/une.md", "une autre page se nomme déjà « une »"),
        ("seance/deux.md", "dossier de pages inconnu"),
    ],
)
def test_a_page_that_has_no_address(course_folder: CourseFolder, path: str, message: str) -> None:
    write_page(course_folder, "une", "A\n")
    found = course_folder.write(f"curriculum/m9/{path}", FULL)
    (problem,) = problems(course_folder, render=False)
    assert problem.path == found
    assert message in problem.message


def test_the_glossary(course_folder: CourseFolder) -> None:
    write_page(course_folder, "une", "::: theoreme #thm-un\nA\n:::\n")
    course_folder.write("curriculum/m9/glossaire.toml", GLOSSARY)
    assert problems(course_folder) == []
    term = module(course_folder).glossary["pose"]
    assert (term.id, term.word, term.page) == ("pose", "pose", "une")
    assert term.text == f"Un triplet (x, y, θ), voir théorème{WIDE}1."
    assert term.html.startswith("Un triplet ")
    assert term.html.endswith(f'voir <a href="/m9/lire/une#thm-un">théorème{WIDE}1</a>.')


ENTRY = '\n[[terme]]\nid = "carte"\nmot = "carte"\ndefinition = "Un plan."\npage = "une"\n'
BAD_GLOSSARY = {
    "unknown key": (ENTRY + 'sens = "x"\n', 12, "champ inconnu : « sens »"),
    "missing key": (ENTRY.replace('mot = "carte"\n', ""), 7, "champ manquant : « mot »"),
    "malformed name": (ENTRY.replace('id = "carte"', 'id = "Carte"'), 8, "nom mal formé"),
    "word defined twice": (ENTRY.replace('id = "carte"', 'id = "pose"'), 8, "mot déjà défini"),
    "unknown page": (ENTRY.replace('page = "une"', 'page = "deux"'), 8, "page inconnue « deux »"),
    "unknown page, quoted otherwise": (ENTRY.replace('"carte"', "'carte'").replace('"une"', "'x'"), 8, "page inconnue"),
    "bad link": (ENTRY.replace("Un plan", "[x](terme:absent)"), 10, "terme inconnu"),
    "bad link below the quotes": (ENTRY.replace('"Un plan."', '"""\n\nUn\n[x](terme:absent)"""'), 13, "terme inconnu"),
}


@pytest.mark.parametrize(("entry", "line", "message"), BAD_GLOSSARY.values(), ids=BAD_GLOSSARY.keys())
def test_a_bad_entry_leaves_the_others(course_folder: CourseFolder, entry: str, line: int, message: str) -> None:
    write_page(course_folder, "une", "::: theoreme #thm-un\nA\n:::\n")
    path = course_folder.write("curriculum/m9/glossaire.toml", GLOSSARY + entry)
    (problem,) = problems(course_folder, render=False, check=True)
    assert (problem.path, problem.line) == (path, line), problem
    assert message in problem.message
    assert "pose" in module(course_folder).glossary


def test_a_glossary_that_cannot_be_read(course_folder: CourseFolder) -> None:
    path = course_folder.write("curriculum/m9/glossaire.toml", 'mot = "x"\n')
    assert [(one.path, one.line) for one in problems(course_folder)] == [(path, 1)]
    path.write_text("[[terme]]\nid =\n", encoding="utf-8")
    assert [(one.path, one.line) for one in problems(course_folder)] == [(path, 2)]


def test_an_exercise_follows_a_page_that_exists(course_folder: CourseFolder) -> None:
    path = course_folder.exercise("a") / "exercise.toml"
    path.write_text(EXERCISE.replace("order = 10", 'order = 10\nseance = "une"'), encoding="utf-8")
    (problem,) = problems(course_folder)
    assert (problem.path, problem.line, problem.message) == (path, 4, "« seance » : page inconnue « une »")
    assert "m9/a" in course_folder.load().exercises
    write_page(course_folder, "une", "A\n", folder="seances")
    assert problems(course_folder) == []
    assert course_folder.load().exercises["m9/a"].seance == "une"


PATHS = """references = ["Un livre.", "La page [Une](page:absente)."]

[[paths]]
title = "Au lycée"
summary = "Sans matrices."
page = "une#s-un"

[[paths]]
title = "En prépa"
summary = "Avec."
page = "deux"
"""


def test_a_module_says_ways_through_it_and_what_to_read(course_folder: CourseFolder) -> None:
    write_page(course_folder, "une", "## Un\n\nA\n")
    path = course_folder.curriculum / "m9" / "module.toml"
    before = path.read_text(encoding="utf-8").rstrip("\n") + "\n"
    path.write_text(before + PATHS, encoding="utf-8")
    start = before.count("\n")
    unknown, lost = problems(course_folder)
    assert (unknown.line, unknown.message) == (start + 11, "« page » : page inconnue « deux »")
    assert (lost.line, lost.message) == (start + 1, "page inconnue : « absente »")
    ways = course_folder.load().modules["m9"].paths
    assert [(one.title, one.page) for one in ways] == [("Au lycée", "une#s-un"), ("En prépa", "deux")]


def test_pages_do_not_change_the_version_of_an_exercise(course_folder: CourseFolder) -> None:
    before = {name: one.version for name, one in course_folder.load(render=False).exercises.items()}
    write_page(course_folder, "une", "A\n")
    course_folder.write("curriculum/m9/glossaire.toml", GLOSSARY)
    course_folder.write("curriculum/m9/figures/dessins.py", FIGURES)
    course_folder.write("curriculum/m9/rejeux/mcl.py", "")
    assert {name: one.version for name, one in course_folder.load(render=False).exercises.items()} == before


def test_nothing_is_read_before_it_is_asked_for(course_folder: CourseFolder, monkeypatch: pytest.MonkeyPatch) -> None:
    """A command that only grades loads the course at each start."""

    def refuse(*_: object) -> None:
        raise AssertionError("a text was read")

    write_page(course_folder, "une", "A\n")
    course_folder.write("curriculum/m9/glossaire.toml", GLOSSARY)
    monkeypatch.setattr("server.text.markup.parser.markdown_parser", refuse)
    assert len(module(course_folder).lessons) == 1


def test_no_formula_is_drawn_when_the_service_starts(
    course_folder: CourseFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> str:
        raise AssertionError("a formula was drawn")

    write_page(course_folder, "une", "Un $x$.\n")
    monkeypatch.setattr("server.text.katex.render_formula", refuse)
    monkeypatch.setattr("server.text.katex.render_formulas_ahead", refuse)
    assert problems(course_folder, render=False, check=True) == []


def test_every_kind_has_a_name_a_folder_and_a_place_of_its_own() -> None:
    for column in ("name", "folder", "numbered"):
        assert len({getattr(kind, column) for kind in KINDS}) == len(KINDS)
