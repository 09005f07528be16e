"""The private folder of a program: it may write there, within bounds, and nothing of it is left."""

from __future__ import annotations

import pytest

from server.sandbox import ProgramFault, Sandbox, WallStatus

from .family import probed
from .limits import only

POLICY = only(folder_bytes=1 << 20, file_bytes=1 << 18)


@pytest.fixture(autouse=True)
def _where_programs_have_a_folder() -> None:
    if probed()["dossier-privé"].status != WallStatus.STANDING:
        pytest.skip("this machine gives a program no namespaces of its own")


def run(body: str, sandbox: Sandbox) -> object:
    source = "import os, tempfile\nimport numpy as np\ndef f():\n" + "".join(f"    {x}\n" for x in body.splitlines())
    with sandbox.open(source.encode(), policy=POLICY) as session:
        return session.call("f").value


def test_files_and_folders_are_made_changed_and_removed(sandbox: Sandbox) -> None:
    body = """
np.save("a.npy", np.arange(3))
os.mkdir("d")
os.rename("a.npy", "d/b.npy")
with tempfile.TemporaryDirectory() as folder:
    open(folder + "/x", "w").write("é")
os.truncate("d/b.npy", os.path.getsize("d/b.npy"))
found = np.load("d/b.npy").tolist()
os.remove("d/b.npy")
os.rmdir("d")
return found, os.listdir(".")
"""
    assert run(body, sandbox) == ([0, 1, 2], [])


def test_the_next_program_finds_an_empty_folder(sandbox: Sandbox) -> None:
    for _ in range(3):
        assert run("seen = os.listdir('.')\nopen('a', 'w').write('x')\nreturn seen", sandbox) == []


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("for k in range(8):\n    open(str(k), 'wb').write(bytes(200_000))", "dossier est plein"),
        ("for k in range(300):\n    open(str(k), 'wb').close()", "dossier est plein"),
        ("open('a', 'wb').write(bytes(300_000))", "fichier est trop gros"),
        ("os.truncate(os.open('a', os.O_CREAT | os.O_RDWR), 10**9)", "fichier est trop gros"),
    ],
    ids=["folder", "number", "file", "sparse"],
)
def test_the_folder_is_bounded(sandbox: Sandbox, body: str, told: str) -> None:
    with pytest.raises(ProgramFault) as caught:
        run(body, sandbox)
    assert not caught.value.fatal
    assert told in caught.value.message


@pytest.mark.parametrize(
    "action",
    [
        "os.symlink('/', 'a')",
        "os.link(np.__file__, 'a')",
        "os.mkfifo('a')",
        "os.mknod('a', 0o20666, os.makedev(1, 1))",
        "open('/home/a', 'w')",
        "open('../a', 'w')",
        "os.chmod('..', 0o777)",
    ],
)
def test_only_plain_files_and_folders_and_only_there(sandbox: Sandbox, action: str) -> None:
    with pytest.raises(ProgramFault) as caught:
        run(action, sandbox)
    assert caught.value.kind == "forbidden_operation"


def test_without_namespaces_there_is_no_folder() -> None:
    with Sandbox({}, POLICY, namespaces=False) as bare, pytest.raises(ProgramFault) as caught:
        bare.open(b"open('a', 'w')")
    assert caught.value.kind == "forbidden_operation"
