"""A template that draws: for sessions that allow it, with the same walls, and figures that are bounded."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from functools import partial

import pytest

from server.sandbox import FaultKind, ProgramFault, Sandbox, Session, WallStatus
from server.sandbox.assaults import ASSAULTS, Assault
from server.sandbox.child import drawing
from server.sandbox.install import DRAWING, find_installation, import_set_of
from server.sandbox.probe import run_assault

from .conftest import Lifting
from .family import probed, template_of
from .limits import only

POLICY = only(memory_bytes=256 << 20, frame_bytes=5 << 20, items=1000)
PYPLOT = "import matplotlib.pyplot as plt\n"


Studio = Callable[..., Session]


@pytest.fixture
def studio(without: Lifting) -> Studio:
    """Opens a session within the limits of these tests."""
    return partial(without(frozenset()).open, policy=POLICY)


def drawn(studio: Studio, source: str) -> tuple[tuple[bytes, ...], str]:
    with studio(source.encode(), drawing=True) as session:
        return session.figures(), session.stdout()


def size(picture: bytes) -> tuple[int, int]:
    assert picture.startswith(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")
    return int.from_bytes(picture[16:20], "big"), int.from_bytes(picture[20:24], "big")


def test_what_is_open_at_the_end_comes_back(studio: Studio) -> None:
    source = PYPLOT + "plt.plot([1, 2])\nplt.title('é $x^2$')\nplt.show()\nplt.figure(figsize=(2, 1))\nprint('fini')"
    pictures, printed = drawn(studio, source)
    assert [size(one) for one in pictures] == [(960, 720), (300, 150)]
    assert printed == "fini\n", "showing on no screen is not worth a warning"
    assert drawn(studio, PYPLOT + "plt.plot([1])\nplt.close()") == ((), "")


def test_scipy_is_within_reach_too(studio: Studio) -> None:
    source = "import scipy.optimize\n" + PYPLOT + "print(scipy.optimize.brentq(lambda x: x - 3, 0, 9))\nplt.plot([1])"
    pictures, printed = drawn(studio, source)
    assert (len(pictures), printed) == (1, "3.0\n")


def test_figures_are_few_and_bounded(studio: Studio) -> None:
    pictures, printed = drawn(studio, PYPLOT + "for _ in range(9):\n    plt.figure(figsize=(1, 1))")
    assert len(pictures) == drawing.MAX_FIGURES
    assert "9 figures" in printed
    noise = "import numpy as np\nplt.figure(figsize=(90, 9))\nplt.imshow(np.random.rand(500, 700, 3), aspect='auto')"
    (picture,), _ = drawn(studio, PYPLOT + noise)
    width, height = size(picture)
    assert width * height <= drawing.MAX_PIXELS
    assert len(picture) <= drawing.MAX_BYTES


@pytest.fixture(params=["namespaces of the machine", "without namespaces"])
def either(request: pytest.FixtureRequest, studio: Studio) -> Iterator[Studio]:
    if request.param == "without namespaces":
        with Sandbox({}, POLICY, spares=0, namespaces=False) as sandbox:
            yield sandbox.open
    else:
        yield studio


def test_dates_glyphs_and_styles_draw_and_name_no_file_of_ours(either: Studio) -> None:
    source = PYPLOT + (
        "import datetime\nplt.style.use('ggplot')\nplt.plot([datetime.date(2026, 1, 1)], [1])\nplt.title('日')\n"
        "plt.figure().add_subplot(projection='3d')\nplt.figure()\nplt.contourf([[1, 2], [3, 4]])"
    )
    pictures, printed = drawn(either, source)
    assert len(pictures) == 3
    assert printed.startswith("UserWarning: Glyph 26085")
    assert "/" not in printed


def test_a_program_that_draws_nothing_has_no_figures(studio: Studio) -> None:
    assert drawn(studio, "print(1)") == ((), "1\n")


def test_submissions_do_not_draw(studio: Studio) -> None:
    session = studio(PYPLOT.encode())
    assert session.figures() == ()
    assert "rien ne se trace pendant l’évaluation" in session.remarks[0]
    assert {import_set_of(source) for source in (b"import matplotlib", b"import numpy")} == {"numpy"}


def test_what_was_printed_before_a_file_failed_to_load_is_kept(studio: Studio) -> None:
    with pytest.raises(ProgramFault) as caught:
        studio(b"print('avant')\n1 / 0", drawing=True)
    assert (caught.value.line, caught.value.stdout, caught.value.stdout_truncated) == (2, "avant\n", False)


@pytest.mark.parametrize(
    ("trick", "start"),
    [
        ("fig.savefig = lambda *a, **k: a[0].write(b'x' * 3)", b"xxx"),
        ("import builtins\nglobals()['<figures>'] = lambda: 'texte'", b"\x89PNG"),
    ],
    ids=["saving", "name"],
)
def test_who_replaces_the_drawing_gives_bytes(studio: Studio, trick: str, start: bytes) -> None:
    """The name is given after the file was loaded; beyond that, a program answers what it wants of itself."""
    (picture,), _ = drawn(studio, PYPLOT + "fig = plt.figure()\n" + trick)
    assert type(picture) is bytes
    assert picture.startswith(start)
    assert len(picture) <= drawing.MAX_BYTES


def test_who_replaces_the_list_of_figures_fails_by_itself(studio: Studio) -> None:
    with pytest.raises(ProgramFault) as caught:
        drawn(studio, PYPLOT + "plt.figure()\nplt.get_fignums = lambda: ['a'] * 3")
    assert caught.value.kind is FaultKind.RUNTIME_ERROR


LIARS = {
    "texte": "'texte'",
    "floats": "(np.zeros(3),)",
    "beaucoup": "tuple(np.zeros(1, np.uint8) for _ in range(9))",
    "gros": "(np.zeros(2 << 20, np.uint8),)",
}


@pytest.mark.parametrize("answer", LIARS.values(), ids=LIARS.keys())
def test_what_is_no_picture_is_an_invalid_answer(studio: Studio, answer: str) -> None:
    """The program climbs to the frames of ours that run it, and replaces what will be given as its figures."""
    source = f"""{PYPLOT}import sys, numpy as np
cadre = sys._getframe()
while cadre:
    if hasattr(cadre.f_globals.get("drawing"), "FIGURES"):
        cadre.f_globals["drawing"].render_open_figures = lambda: {answer}
    cadre = cadre.f_back
"""
    with studio(source.encode(), drawing=True) as session, pytest.raises(ProgramFault) as caught:
        session.figures()
    assert caught.value.kind is FaultKind.INVALID_OUTPUT


def test_nothing_of_the_machine_is_seen_or_written(studio: Studio) -> None:
    source = PYPLOT + (
        "import matplotlib, matplotlib.font_manager as fonts, os\n"
        "dossier = matplotlib.get_data_path()\n"
        "polices = [f.fname for f in fonts.fontManager.ttflist + fonts.fontManager.afmlist]\n"
        "print(len(polices) > 30, all(p.startswith(dossier) for p in polices))\n"
        "plt.savefig('a.png')\n"
        "print(os.listdir('.'), matplotlib.get_backend().lower(), dict(os.environ))\n"
        "try:\n    plt.savefig('/tmp/a.png')\nexcept OSError:\n    print('refusé')\n"
    )
    _, printed = drawn(studio, source)
    assert printed.splitlines() == ["True True", "['a.png'] agg {}", "refusé"]


def test_the_packages_beside_those_that_draw_are_out_of_sight(without: Lifting) -> None:
    """The project itself may be installed there. (A shared library that something has loaded is there alone.)"""
    (site, *_) = find_installation(DRAWING).sites
    source = f"""# matplotlib
import os
def f(x):
    files = [os.path.join(top, name) for top, _, names in os.walk({site!r}) for name in names]
    return sorted({{os.path.relpath(name, {site!r}).split("/")[0] for name in files if ".so" not in name}})
"""
    with without(frozenset({"landlock", "seccomp"})).open(source.encode(), policy=POLICY, drawing=True) as session:
        seen = session.call("f", 1).value
    assert isinstance(seen, list)
    packages = {os.path.basename(path) for path in find_installation(DRAWING).packages}
    assert {"matplotlib", "numpy"} <= set(seen) <= packages


def test_two_programs_share_nothing(studio: Studio) -> None:
    poison = PYPLOT + "import sys, matplotlib\nplt.savefig = plt.figure = None\nmatplotlib.trace = open('a', 'w')"
    look = PYPLOT + "import os, matplotlib\nplt.figure()\nprint(hasattr(matplotlib, 'trace'), os.listdir('.'))"

    def assert_untouched() -> None:
        pictures, printed = drawn(studio, look)
        assert (len(pictures), printed) == (1, "False []\n")

    with studio(poison.encode(), drawing=True):
        assert_untouched()
    assert_untouched()


@pytest.mark.parametrize("assault", [a for a in ASSAULTS if not a.slow], ids=lambda assault: str(assault.name))
def test_the_walls_are_the_same(assault: Assault, without: Lifting) -> None:
    """As the probe finds them, which makes the same assaults on the template of submissions."""
    report = probed()[assault.name]
    if report.status == WallStatus.UNAVAILABLE:
        pytest.skip(report.detail)
    held = run_assault(assault, template_of(without(assault.masking_walls), DRAWING)) == ""
    assert held == (report.status == WallStatus.STANDING)
