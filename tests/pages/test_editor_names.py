"""The names that an editor proposes: what an exercise's page says and what programs find, never its solution's."""

from __future__ import annotations

import re
from typing import Any

import pytest

from server.pages.editor_names import names_for
from server.pages.python_names import BUILTINS, NUMPY
from tests.support.quick import the_course
from tests.support.small_site import SmallSite

CODE = [exercise for exercise in the_course().exercises.values() if exercise.kind == "code"]


def test_the_address_gives_names_with_their_arguments(small_site: SmallSite) -> None:
    names = small_site.client.get("/m9/exercices/a/noms.json").json()["names"]
    by_name: dict[str, Any] = {one["name"]: one for one in names}
    assert len(by_name) == len(names)
    assert by_name["len"] == {"name": "len", "signature": "(valeurs)", "doc": "combien il y en a"}
    assert {"np.zeros", "double"} <= set(by_name)
    page = small_site.get("/m9/exercices/a")
    assert 'data-names="/m9/exercices/a/noms.json"' in page
    assert small_site.client.get("/m9/exercices/absent/noms.json").status_code == 404


@pytest.mark.parametrize(
    ("exercise", "name", "signature", "doc"),
    [
        ("l20/mcl", "estimer", "(particules, poids)", "la pose que le nuage annonce"),
        ("l20/mcl", "lidar_lot", "(poses, n_rayons)", "Scans (m, n_rayons) sans bruit vus depuis m poses (m, 3)."),
        ("l20/mcl", "libres", "", "vaut True là où le robot peut se tenir"),
        ("l20/mcl", "inverse", "(a)", ".* ; à importer : from mes_fonctions import inverse"),
        ("l20/kabsch", "np.eye", "(n)", "la matrice identité"),
        ("l20/noeud_ros", "rclpy.init", "(args=None, .*)", "À appeler avant de créer un nœud."),
        ("l20/noeud_ros", "self.create_publisher", "(msg_type, .*)", ".*"),
    ],
)
def test_a_name_comes_with_its_arguments_and_a_line(exercise: str, name: str, signature: str, doc: str) -> None:
    course = the_course()
    [found] = [one for one in names_for(course, course.exercises[exercise]) if one.name == name]
    assert re.fullmatch(re.escape(signature).replace(r"\.\*", ".*"), found.signature)
    assert re.fullmatch(doc, found.doc) or found.doc == doc


@pytest.mark.parametrize("exercise", [one.id for one in CODE])
def test_no_name_is_only_in_the_solution(exercise: str) -> None:
    course = the_course()
    asked = course.exercises[exercise]
    kit = "\n".join(course.kits[asked.kit].values())
    earlier = [function.name for one in course.reused(exercise) for function in one.functions]
    said = "\n".join([asked.statement.source.text, asked.starter, kit, *earlier])
    everyday = {*BUILTINS, *NUMPY}
    for one in names_for(course, asked):
        last = one.name.rpartition(".")[2]
        assert one.name in everyday or re.search(rf"\b{last}\b", said), one.name
