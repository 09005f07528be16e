"""The chosen path decides of the next exercise, and the module's order agrees with the page that tells the paths."""

from __future__ import annotations

import re

import pytest

from server.course import Course
from server.course.models import ReadingPath
from tests.hunts.test_service import right
from tests.support.service import Site

PREPA = "chemins#s-le-chemin-prepa"
TOLD = re.compile(r"\(exo:(\w+)\)")
SKIPPED = "**Ce que l'on peut sauter**"


@pytest.mark.parametrize(("number", "heading"), [(0, "## Le chemin lycée"), (1, "## Le chemin prépa")])
def test_each_path_lists_the_exercises_of_its_page_in_their_order(course: Course, number: int, heading: str) -> None:
    module = course.modules["l20"]
    path: ReadingPath = module.paths[number]
    page = next(lesson for lesson in module.lessons if lesson.slug == "chemins")
    part = page.text.source.text.split(heading)[1].split("\n## ")[0]
    todo, _, skipped = part.partition(SKIPPED)
    told = list(dict.fromkeys(TOLD.findall(todo)))
    assert [slug for slug in path.exercises if slug in told] == told
    assert set(path.exercises) - set(told) <= {"verification", "epreuve_calculs", "epreuve_lecture", "epreuve_preuve"}
    assert not set(path.exercises) & (set(TOLD.findall(skipped)) - {"verification"})


def test_the_chosen_path_gives_the_next_exercise_with_its_reason(site: Site) -> None:
    for slug in ("odometrie",):
        site.client.post(f"/l20/exercices/{slug}/soumissions", data={"code": "x = 1\n"})
    assert site.worker_with(right).run_one()
    assert "/l20/exercices/calcul_odometrie" in site.client.get("/").text, "what follows, not what was passed over"
    assert site.client.post("/l20/chemin", data={"chemin": PREPA}).headers["location"] == "/l20"
    home = site.client.get("/").text
    assert "c’est la suite de votre chemin" in home
    assert "/l20/exercices/lidar" in home
    assert "/l20/exercices/calcul_odometrie" not in home
    module = site.client.get("/l20").text
    assert "Quitter ce chemin" in module
    assert re.search(r"lidar\">Exercice suivant", module)
    solved = site.client.get("/l20/exercices/odometrie").text
    assert 'lidar">Ensuite' in solved
    assert "Pourquoi cet exercice ensuite" in solved
    assert '<details class="fold" open>' in solved, "the solution"
    assert site.client.post("/l20/chemin", data={"chemin": "ailleurs"}).status_code == 422
    site.client.post("/l20/chemin", data={"chemin": ""})
    assert "/l20/exercices/calcul_odometrie" in site.client.get("/").text


def test_the_paths_of_every_module_name_its_exercises_and_lead_to_a_heading(course: Course) -> None:
    for slug in ("l19", "l20"):
        module = course.modules[slug]
        lessons = {lesson.slug: {heading.id for heading in lesson.headings} for lesson in module.lessons}
        assert len({path.page for path in module.paths}) == len(module.paths) == 2
        for path in module.paths:
            page, _, heading = path.page.partition("#")
            assert not heading or heading in lessons[page], path.page
            assert path.exercises
            assert set(path.exercises) <= {exercise.slug for exercise in module.exercises}
