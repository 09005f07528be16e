"""What one takes away: an archive that is the same each time, with what the practical work says of it."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from reference.formats.map_server import read_map
from reference.formats.trajectory_files import read_tum
from reference.metrics import absolute_trajectory_error
from reference.odometry import DifferentialDrive, integrate_poses
from server.base.errors import NotFound
from server.base.files import reproducible_zip
from server.base.settings import Settings
from server.reading.downloads import DownloadArchives
from tests.support.client import TestClient
from tests.support.quick import migrated, standing_app, the_course


@pytest.fixture(scope="module")
def journey() -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(DownloadArchives(the_course()).build_archive("l20", "parcours"))) as archive:
        assert archive.testzip() is None
        return {name.removeprefix("parcours/"): archive.read(name) for name in archive.namelist()}


@pytest.fixture
def site_of_the_course(tmp_path: Path) -> Iterator[TestClient]:
    settings = Settings(data_dir=tmp_path / "data", workers=0)
    database = migrated(settings)
    with TestClient(standing_app(settings, the_course())) as client:
        yield client
    database.close()


def table(content: bytes) -> np.ndarray:
    return np.loadtxt(io.BytesIO(content), delimiter=",", skiprows=1)


def test_the_plain_files_give_what_the_text_says(journey: dict[str, bytes]) -> None:
    wheels, scans, truth = (
        table(journey["roues.csv"]),
        table(journey["scans.csv"]),
        read_tum(journey["verite.tum"].decode()),
    )
    assert (wheels.shape, scans.shape, len(truth)) == ((1044, 3), (1045, 181), 1045)
    assert scans[:, 1:].max() == 8.0
    told = integrate_poses(DifferentialDrive(0.3), wheels[:, 1:], truth.to_planar()[0])
    assert absolute_trajectory_error(truth.to_planar(), told).rmse == pytest.approx(0.58, abs=0.006)
    assert np.hypot(*(told[-1] - truth.to_planar()[-1])[:2]) == pytest.approx(1.10, abs=0.006)
    world = read_map(journey["carte.yaml"].decode(), journey["carte.pgm"]).to_grid_map()
    assert world.is_free(truth.to_planar()[:, :2]).all()


def test_the_bag_leaves_the_localisation_to_its_reader(journey: dict[str, bytes], tmp_path: Path) -> None:
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    from rosbags.typesys import Stores, get_typestore

    for name in ("run.mcap", "metadata.yaml"):
        (tmp_path / name).write_bytes(journey[f"bag/{name}"])
    store = get_typestore(Stores.ROS2_HUMBLE)
    with rosbag2.Reader(tmp_path) as reader:
        assert {one.topic: one.msgcount for one in reader.connections}["/scan"] == 1045
        tf = [one for one in reader.connections if one.topic == "/tf"]
        _, _, data = next(reader.messages(tf))
        links = [
            (link.header.frame_id, link.child_frame_id)
            for link in store.deserialize_cdr(data, tf[0].msgtype).transforms
        ]
    assert links == [("odom", "base_link"), ("base_link", "laser")]


def test_the_same_files_make_the_same_archive() -> None:
    files = {"b.txt": b"2", "a/c.txt": b"1"}
    assert reproducible_zip("x", files) == reproducible_zip("x", dict(reversed(files.items())))


@pytest.mark.parametrize(("module", "name"), [("l20", "absent"), ("l99", "parcours"), ("l20", "../kit/l20")])
def test_what_is_not_offered_is_not_found(module: str, name: str) -> None:
    with pytest.raises(NotFound):
        DownloadArchives(the_course()).build_archive(module, name)


def test_it_comes_as_a_file(site_of_the_course: TestClient) -> None:
    answer = site_of_the_course.get("/l20/fichiers/parcours.zip")
    assert answer.headers["content-type"] == "application/zip"
    assert answer.headers["content-disposition"] == 'attachment; filename="parcours.zip"'
    assert site_of_the_course.get("/l20/fichiers/absent.zip").status_code == 404
    assert 'href="/l20/fichiers/parcours.zip"' in site_of_the_course.get("/l20/lire/slam-navigation").text


def test_the_real_scans_come_with_what_says_them() -> None:
    with zipfile.ZipFile(io.BytesIO(DownloadArchives(the_course()).build_archive("l20", "intel"))) as archive:
        files = {name.removeprefix("intel/"): archive.read(name) for name in archive.namelist()}
    told = files["LISEZ-MOI.txt"].decode()
    assert all(name in told for name in files.keys() - {"LISEZ-MOI.txt"})
    tables = [table(files[name]) for name in ("scans.csv", "odometrie.csv", "boucles.csv", "tout/scans.csv")]
    assert [rows.shape for rows in tables] == [(120, 180), (120, 3), (23, 5), (910, 180)]
    assert len(read_tum(files["reference.tum"].decode())) == 120
    assert len(read_tum(files["tout/reference.tum"].decode())) == len(table(files["tout/odometrie.csv"])) == 910
