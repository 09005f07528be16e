"""Kits as one takes them away: a file, or an archive that works where there is no ROS."""

from __future__ import annotations

import io
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from server.base.errors import NotFound
from server.pages.kits import build_kit_download, kit_file_name
from tests.support.quick import the_course
from tests.support.small_site import SmallSite


def test_a_kit_of_one_file_is_that_file_and_another_an_archive() -> None:
    module = the_course().modules["l20"]
    assert [kit_file_name(module, kit) for kit in module.kits] == ["l20.py", "ros.zip"]
    assert the_course().exercises["l20/noeud_ros"].kit == "ros"
    assert build_kit_download(module, "l20.py").content.startswith('"""Le monde simulé'.encode())
    archive = zipfile.ZipFile(io.BytesIO(build_kit_download(module, "ros.zip").content))
    assert {"ros/l20.py", "ros/ros.py", "ros/rclpy/node.py", "ros/sensor_msgs/msg.py"} <= set(archive.namelist())
    for absent in ("ros.py", "l20.zip", "rclpy.py", "../l20.py"):
        with pytest.raises(NotFound):
            build_kit_download(module, absent)


def test_the_page_s_address_serves_it(small_site: SmallSite) -> None:
    answer = small_site.client.get("/m9/kit/m9.py")
    assert answer.headers["content-disposition"] == 'attachment; filename="m9.py"'
    assert answer.headers["content-type"].startswith("text/x-python")


@pytest.mark.slow
def test_the_archive_works_at_home(tmp_path: Path) -> None:
    module = the_course().modules["l20"]
    zipfile.ZipFile(io.BytesIO(build_kit_download(module, "ros.zip").content)).extractall(tmp_path)
    home = tmp_path / "ros"
    (home / "noeud.py").write_text(the_course().exercises["l20/noeud_ros"].solution, encoding="utf-8")
    text = (home / "ros.py").read_text(encoding="utf-8")
    example = text.split("par exemple :\n\n")[1].split("\n\nSur une machine")[0]
    lines = [line.removeprefix("    ") for line in example.splitlines()]
    (home / "essai.py").write_text("\n".join(["from noeud import ArretUrgence", *lines]), encoding="utf-8")
    done = subprocess.run([sys.executable, "essai.py"], cwd=home, capture_output=True, text=True, check=True)
    assert "'topic': '/cmd_vel'" in done.stdout
    subprocess.run([sys.executable, "noeud.py"], cwd=home, check=True, timeout=300)
