"""Pictures on disk: what is damaged is not there, what is old leaves, and nobody else may look."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from server.figures.store import PictureFileStore

A, B, C = (letter * 64 for letter in "abc")


def stat(path: Path) -> str:
    return oct(path.stat().st_mode & 0o777)


def test_what_is_kept_is_found_by_the_next_process_and_by_nobody_else(tmp_path: Path) -> None:
    folder = tmp_path / "data" / "figures"
    PictureFileStore(folder).put(A, b"picture")
    assert PictureFileStore(folder).get(A) == b"picture"
    assert PictureFileStore(folder).get(B) is None
    assert (stat(folder), stat(folder / A)) == ("0o700", "0o600")
    assert [path.name for path in folder.iterdir()] == [A]


def test_a_folder_that_others_could_read_is_closed(tmp_path: Path) -> None:
    tmp_path.chmod(0o755)
    PictureFileStore(tmp_path).put(A, b"picture")
    assert stat(tmp_path) == "0o700"


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "cut": lambda content: content[:-1],
    "empty": lambda _: b"",
    "only its seal": lambda content: content[:32],
    "changed": lambda content: content[:-1] + b"?",
    "zeros": lambda content: bytes(len(content)),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES.keys())
@pytest.mark.parametrize("restarted", [True, False])
def test_a_damaged_file_is_not_there_and_is_replaced(
    tmp_path: Path, damage: Callable[[bytes], bytes], restarted: bool
) -> None:
    store = PictureFileStore(tmp_path)
    store.put(A, b"picture")
    (tmp_path / A).write_bytes(damage((tmp_path / A).read_bytes()))
    store = PictureFileStore(tmp_path) if restarted else store
    assert store.get(A) is None
    assert not (tmp_path / A).exists()
    store.put(A, b"picture")
    assert PictureFileStore(tmp_path).get(A) == b"picture"


def test_a_file_that_somebody_took_away_is_not_there(tmp_path: Path) -> None:
    store = PictureFileStore(tmp_path)
    store.put(A, b"picture")
    (tmp_path / A).unlink()
    assert store.get(A) is None


def test_what_was_being_written_when_the_process_died_is_swept(tmp_path: Path) -> None:
    (tmp_path / f"{A}.new").write_bytes(b"pict")
    (tmp_path / "notes.txt").write_bytes(b"not ours")
    store = PictureFileStore(tmp_path)
    assert store.get(A) is None
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


ROOM = 2 * (32 + 10)


def test_what_was_used_least_lately_leaves_the_disk(tmp_path: Path) -> None:
    store = PictureFileStore(tmp_path, ROOM)
    store.put(A, b"0123456789")
    store.put(B, b"0123456789")
    assert store.get(A)
    store.put(C, b"0123456789")
    assert {path.name for path in tmp_path.iterdir()} == {A, C}
    assert store.get(B) is None


def test_the_order_of_use_and_a_smaller_bound_hold_after_a_restart(tmp_path: Path) -> None:
    store = PictureFileStore(tmp_path)
    for age, key in enumerate((A, B, C)):
        store.put(key, b"0123456789")
        os.utime(tmp_path / key, (1000 + age, 1000 + age))
    assert store.get(A)
    narrow = PictureFileStore(tmp_path, ROOM)
    assert [narrow.get(key) is not None for key in (A, B, C)] == [True, False, True]
    assert {path.name for path in tmp_path.iterdir()} == {A, C}


def test_a_picture_larger_than_all_is_not_kept_and_puts_nothing_out(tmp_path: Path) -> None:
    store = PictureFileStore(tmp_path, ROOM)
    store.put(A, b"0123456789")
    store.put(B, bytes(ROOM))
    assert {path.name for path in tmp_path.iterdir()} == {A}
    assert store.get(A)


def test_a_full_disk_costs_a_drawing_and_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(self: Path, target: Path) -> Path:
        raise OSError(28, "No space left on device")

    store = PictureFileStore(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", full)
        store.put(A, b"picture")
    assert store.get(A) is None
    assert list(tmp_path.iterdir()) == []
    store.put(A, b"picture")
    assert store.get(A) == b"picture"
