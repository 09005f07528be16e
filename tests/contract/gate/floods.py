"""The floods that the gate is held against: what one visitor can do with nothing but HTTP. To add one, add a row."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict, dataclass

from server.sandbox import Policy
from tests.contract.gate.attacker import Attacker
from tests.support.live import PROJECT

ALL = frozenset({"page", "verdict", "cell", "steps", "board", "figure", "login"})
#: Of what takes no grader nor helper.
PAGES = frozenset({"page", "verdict", "board"})


@dataclass(frozen=True)
class Flood:
    """Something that is done again and again by `at_once` threads; the `doors` that are measured meanwhile."""

    name: str
    act: Callable[[Attacker], object]
    doors: frozenset[str] = PAGES
    at_once: int = 4
    #: Whether it is part of the fast gate.
    fast: bool = False


# Connections


def one_byte_chunks(attacker: Attacker) -> None:
    head = b"POST /connexion HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n"
    attacker.send_pieces(head, b"1\r\na\r\n" * 2000, 200)


def many_headers(attacker: Attacker) -> None:
    attacker.send_pieces(b"GET /healthz HTTP/1.1\r\nHost: a\r\n", b"a:b\r\n" * 1000, 12)


def long_headers(attacker: Attacker) -> None:
    attacker.send_pieces(b"GET /healthz HTTP/1.1\r\nHost: a\r\nx: ", b"y" * 4000, 2000)


def header_byte_by_byte(attacker: Attacker) -> None:
    attacker.send_pieces(b"GET /healthz HTTP/1.1\r\nHost: a\r\nx: ", b"y", 60_000)


def slow_loris(attacker: Attacker) -> None:
    attacker.send_pieces(b"GET / HTTP/1.1\r\nHost: a\r\n", b"x: y\r\n", 100, 0.1)


def half_bodies(attacker: Attacker) -> None:
    attacker.send_pieces(
        b"POST /connexion HTTP/1.1\r\nHost: a\r\nContent-Type: application/x-www-form-urlencoded\r\n"
        b"Content-Length: 400000\r\n\r\n",
        b"a",
        3000,
    )


def pipelined(attacker: Attacker) -> None:
    """Requests whose answers nobody reads."""
    attacker.send_pieces(b"", b"GET /l20 HTTP/1.1\r\nHost: a\r\n\r\n" * 50, 40)


def unread_answers(attacker: Attacker) -> None:
    attacker.send_pieces(b"GET /l20/lire/glossaire HTTP/1.1\r\nHost: a\r\n\r\n", b"", 20, 0.05)


def expectations(attacker: Attacker) -> None:
    attacker.send_pieces(
        b"POST /connexion HTTP/1.1\r\nHost: a\r\nExpect: 100-continue\r\nContent-Length: 9\r\n\r\n", b"a", 8, 0.01
    )


def upgrades(attacker: Attacker) -> None:
    attacker.send_pieces(
        b"GET / HTTP/1.1\r\nHost: a\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
        b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n",
        b"",
        1,
    )


# Requests


def missing_pages(attacker: Attacker) -> None:
    attacker.request("GET", "/" + "/".join(f"{attacker.random.random()}" for _ in range(100)))


def other_methods(attacker: Attacker) -> None:
    for method in ("HEAD", "OPTIONS", "PROPFIND", "TRACE"):
        attacker.request(method, attacker.random.choice(["/l20", "/", "/api/v1/exercises", "/connexion"]))


def many_parameters(attacker: Attacker) -> None:
    attacker.request("GET", "/l20/recherche?" + "&".join(f"q={k}" for k in range(6000)))


def long_search(attacker: Attacker) -> None:
    words = " ".join(attacker.random.choice(["robot", "lidar", "carte", "a", "é"]) for _ in range(1000))
    attacker.request("GET", "/l20/recherche?q=" + words[:4000].replace(" ", "+").replace("é", "%C3%A9"))


def huge_cookies(attacker: Attacker) -> None:
    attacker.request("GET", "/l20", cookie="; ".join(f"c{k}={k}" for k in range(5000)))


def ranges(attacker: Attacker) -> None:
    _, _, page = attacker.request("GET", "/l20") if "static" not in attacker.state else (0, "", b"")
    if page:
        attacker.state["static"] = page.partition(b'href="/static/')[2].partition(b'"')[0].decode()
    spans = ",".join(f"{k}-{k}" for k in range(0, 4000, 2))
    attacker.request("GET", "/static/" + attacker.state["static"], Range=f"bytes={spans}")


def deep_json(attacker: Attacker) -> None:
    body = b'{"code":' * 50_000 + b"1" + b"}" * 50_000
    attacker.request("POST", "/l20/cellules", body, cookie=attacker.guest, kind="application/json")


def wide_json(attacker: Attacker) -> None:
    body = json.dumps({f"k{k}": k for k in range(40_000)})
    attacker.request("POST", "/l20/cellules", body, cookie=attacker.guest, kind="application/json")


def huge_forms(attacker: Attacker) -> None:
    attacker.request("POST", "/connexion", "&".join(["a=b"] * 120_000))


def percent_forms(attacker: Attacker) -> None:
    attacker.request("POST", "/connexion", "name=" + "%E9" * 170_000)


def many_parts(attacker: Attacker) -> None:
    part = b'--x\r\nContent-Disposition: form-data; name="a"\r\n\r\nb\r\n'
    body = part * 9000 + b"--x--\r\n"
    attacker.request("POST", "/l20/exercices/poses/soumissions", body, kind="multipart/form-data; boundary=x")


def wrong_passwords(attacker: Attacker) -> None:
    form = {"login": f"x{attacker.random.random()}", "password": "y" * 1000}
    attacker.request("POST", "/connexion", form)


def sign_ups(attacker: Attacker) -> None:
    form = {"name": "x", "login": f"x{attacker.random.random()}"[:30], "password": "une phrase assez longue"}
    attacker.request("POST", "/inscription", form)


def new_guests(attacker: Attacker) -> None:
    attacker.request("POST", "/l20/cellules", '{"code": ""}', kind="application/json")


def wrong_tokens(attacker: Attacker) -> None:
    attacker.request("GET", "/api/v1/exercises", Authorization=f"Bearer {attacker.random.random()}")


def downloads(attacker: Attacker) -> None:
    attacker.request(
        "GET", attacker.random.choice(["/l20/hors-ligne.zip", "/l20/fichiers/intel.zip", "/l20/glossaire"])
    )


def replays(attacker: Attacker) -> None:
    attacker.request("GET", "/l20/rejeux/" + attacker.random.choice(["mcl", "icp", "ekf", "x"]))


def exports(attacker: Attacker) -> None:
    attacker.request("GET", "/compte/donnees", cookie=attacker.guest)


def streams(attacker: Attacker) -> None:
    """Streams of events, as many as there are threads."""
    path = attacker.random.choice(attacker.target.attempts)
    attacker.send_pieces(
        f"GET {path}/evenements HTTP/1.1\r\nHost: a\r\nCookie: {attacker.guest}\r\n\r\n".encode(), b"", 50, 0.1
    )


def boards(attacker: Attacker) -> None:
    path = f"/classes/{attacker.target.teachers_class}/evenements"
    attacker.send_pieces(
        f"GET {path} HTTP/1.1\r\nHost: a\r\nCookie: {attacker.target.teacher}\r\n\r\n".encode(), b"", 20, 0.05
    )


def heads(attacker: Attacker) -> None:
    attacker.request(attacker.random.choice(["HEAD", "OPTIONS"]), "/l20/exercices/poses")


def conditional_requests(attacker: Attacker) -> None:
    tags = ", ".join(f'W/"{attacker.random.random()}"' for _ in range(300))
    attacker.request("GET", "/l20/exercices/poses", If_None_Match=tags)


def probes(attacker: Attacker) -> None:
    """Requests of what watches the service: they wait for no turn."""
    attacker.request("GET", attacker.random.choice(["/healthz", "/readyz", "/metrics", "/statusz"]))


def made_up_sessions(attacker: Attacker) -> None:
    attacker.request("GET", "/l20/exercices/poses", cookie=f"balise_session={attacker.random.random()}")


def log_outs(attacker: Attacker) -> None:
    attacker.request("POST", "/deconnexion", "", cookie=f"balise_session={attacker.random.random()}")


def searches_like_patterns(attacker: Attacker) -> None:
    pattern = attacker.random.choice(["(a%2B)%2B$", "[[[[", ".*" * 200, "%5C" * 300, "a*" * 400, "%22" * 999])
    attacker.request("GET", f"/l20/recherche?q={pattern}")


def documentation(attacker: Attacker) -> None:
    attacker.request("GET", attacker.random.choice(["/docs", "/api/v1/openapi.json", "/l20/lire/glossaire"]))


def codes_of_classes(attacker: Attacker) -> None:
    attacker.request("GET", f"/rejoindre/{attacker.random.randrange(10**8)}")


def streams_again(attacker: Attacker) -> None:
    """Streams that are opened, and left at once."""
    path = attacker.random.choice(attacker.target.attempts)
    with attacker.connection() as bare:
        bare.sendall(f"GET {path}/evenements HTTP/1.1\r\nHost: a\r\nCookie: {attacker.guest}\r\n\r\n".encode())
        bare.recv(1)


def hang_ups(attacker: Attacker) -> None:
    """Requests whose sender has left before they are served."""
    with attacker.connection() as bare:
        bare.sendall(b"GET /l20/exercices/poses HTTP/1.1\r\nHost: a\r\n\r\n")
    attacker.stopped.wait(0.01)


def connections_left(attacker: Attacker) -> None:
    """Forty connections at once, each with a request whose answer nobody reads."""
    path = attacker.random.choice(["/l20", "/classes/x/evenements", "/soumissions/x"])
    with ExitStack() as stack:
        for _ in range(40):
            bare = stack.enter_context(attacker.connection())
            bare.sendall(f"GET {path} HTTP/1.1\r\nHost: a\r\n\r\n".encode())
        attacker.stopped.wait(0.5)


def bodies_that_wait(attacker: Attacker) -> None:
    """Bodies as large as may be, many at once: who waits for a turn has been read."""
    attacker.request("POST", "/l20/exercices/poses/soumissions", "code=" + "y" * 500_000)


def questions(attacker: Attacker) -> None:
    attacker.request("POST", "/l20/exercices/poses/questions", {"texte": "> " * 1900}, cookie=attacker.guest)


def quiz_answers(attacker: Attacker) -> None:
    attacker.request("POST", "/l20/exercices/verification/soumissions", {"q1": "1"}, cookie=attacker.guest)


def programs_of_strangers(attacker: Attacker) -> None:
    """Each without a session, hence of a new guest."""
    form = {"code": f"{attacker.target.code}\n# {attacker.random.random()}"}
    attacker.request("POST", "/l20/exercices/poses/soumissions", form)


# What is read of a visitor


def colouring(attacker: Attacker) -> None:
    if "attempt" not in attacker.state:
        bomb = attacker.random.choice(
            ["match" + " " * 16_000 + "x", "'%" + "0" * 8000, 'f"' + "{" * 10_000, "(" * 20_000, "'" * 30_001]
        )
        attempt = attacker.submit(bomb)
        if attempt:
            attacker.state["attempt"] = attempt
        return
    attacker.request("GET", attacker.state["attempt"], cookie=attacker.guest)
    if attacker.random.random() < 0.2:
        del attacker.state["attempt"]


def list_bombs(attacker: Attacker) -> None:
    line = attacker.random.choice(["a;b\n", "x,y;z\t\n", '"' * 3 + "\n", "é" * 50 + "@b.fr;\n"])
    path = f"/classes/{attacker.target.teachers_class}/liste"
    attacker.request("POST", path, {"texte": line * (200_000 // len(line))}, cookie=attacker.target.teacher)


def gradebook_files(attacker: Attacker) -> None:
    path = f"/classes/{attacker.target.teachers_class}/carnet/fichier"
    attacker.request("GET", path, cookie=attacker.target.teacher)


def archives_of_copies(attacker: Attacker) -> None:
    path = f"/classes/{attacker.target.teachers_class}/carnet/copies"
    attacker.request("GET", path, cookie=attacker.target.teacher)


def long_files(attacker: Attacker) -> None:
    """The page of an attempt as long as may be, again and again."""
    if not attacker.state.get("long"):
        attacker.state["long"] = attacker.submit(attacker.random.choice(["#\n" * 30_000, "f'{x}'\n" * 9000]))
        return
    attacker.request("GET", attacker.state["long"], cookie=attacker.guest)


def comments(attacker: Attacker) -> None:
    text = attacker.random.choice(["*_" * 5000, "[" * 5000, "`" * 5000, "$" * 5000, "> " * 5000])
    attempt = attacker.target.attempts[attacker.number % len(attacker.target.attempts)]
    attacker.request("POST", f"{attempt}/commentaires", {"texte": text}, cookie=attacker.guest)


# Programs


def program(*lines: str) -> Callable[[Attacker], object]:
    """Return the act of sending a file; each call has another comment, hence another digest."""
    text = "\n".join(lines)
    return lambda attacker: attacker.submit(text)


def _all_functions(*lines: str) -> str:
    body = "\n    ".join(lines)
    return f"import os, sys\ndef f(*a):\n    {body}\nramener = composer = inverse = relatif = f\n"


def hostile(name: str) -> Callable[[Attacker], object]:
    """Return the act of sending a program of `tests/hostile/juge`, which attacks who reads its answers."""
    limits = {key: value for key, value in asdict(Policy()).items() if isinstance(value, int)}
    text = (PROJECT / "tests" / "hostile" / "juge" / name).read_text(encoding="utf-8")
    return program(f"LIMITES = {limits}", text, "ramener = composer = inverse = relatif = repondre")


def cells(code: str) -> Callable[[Attacker], object]:
    body = json.dumps({"code": code})
    return lambda attacker: attacker.request(
        "POST", "/l20/cellules", body, cookie=attacker.guest, kind="application/json"
    )


def step_loops(attacker: Attacker) -> None:
    body = json.dumps({"code": "while True:\n    pass"})
    attacker.request("POST", "/l20/cellules/pas", body, cookie=attacker.guest, kind="application/json")


def figures(attacker: Attacker) -> None:
    """Figures of a wrong answer that nobody has drawn."""
    attempt = attacker.submit(attacker.target.code + f"\ncomposer = lambda a, b: a + {attacker.random.random()}\n")
    for _ in range(20):
        if not attempt or attacker.stopped.wait(0.2):
            return
        _, _, page = attacker.request("GET", attempt, cookie=attacker.guest)
        found = page.partition(f"{attempt}/figures/".encode())[2].partition(b'"')[0].decode()
        if found:
            for theme in ("light", "dark"):
                path = found.partition("?")[0]
                attacker.request("GET", f"{attempt}/figures/{path}?theme={theme}", cookie=attacker.guest)
            return


HOGS = "b = []\nwhile True:\n    b.append(bytearray(1 << 20))"
OUTPUT = "while True:\n    print('x' * 10000)"
DRAWINGS = "import matplotlib.pyplot as p\nfor k in range(40):\n    p.plot(range(9999))"
FORKS = """import os
while True:
    try:
        os.fork()
    except BaseException:
        pass"""
THREADS = """import threading
while True:
    try:
        threading.Thread(target=lambda: [0 for _ in iter(int, 1)]).start()
    except BaseException:
        pass"""
DISK = """k = 0
while True:
    k += 1
    try:
        open(f'f{k}', 'w').write('x' * 100000)
    except BaseException:
        pass"""

_ROWS = [
    Flood("one-byte chunks", one_byte_chunks, fast=True),
    Flood("many headers", many_headers, fast=True),
    Flood("long headers", long_headers),
    Flood("a header byte by byte", header_byte_by_byte),
    Flood("slow loris", slow_loris, at_once=200, fast=True),
    Flood("half a body, byte by byte", half_bodies, fast=True),
    Flood("pipelined requests", pipelined),
    Flood("answers unread", unread_answers, at_once=50),
    Flood("expectations", expectations, at_once=20),
    Flood("upgrades", upgrades),
    Flood("missing pages", missing_pages),
    Flood("other methods", other_methods),
    Flood("many parameters", many_parameters),
    Flood("search with 4,000 characters", long_search, fast=True),
    Flood("huge cookies", huge_cookies),
    Flood("ranges of a file", ranges),
    Flood("deep JSON", deep_json, fast=True),
    Flood("wide JSON", wide_json),
    Flood("huge forms", huge_forms, fast=True),
    Flood("forms of percent signs", percent_forms),
    Flood("forms of many parts", many_parts),
    Flood("wrong passwords", wrong_passwords, PAGES | {"login"}, 20, fast=True),
    Flood("accounts opened", sign_ups, PAGES | {"login"}, 20),
    Flood("new guests", new_guests),
    Flood("wrong tokens", wrong_tokens),
    Flood("archives", downloads),
    Flood("replays of lessons", replays),
    Flood("exports of one's data", exports),
    Flood("streams of attempts", streams, at_once=100),
    Flood("streams of a board", boards, at_once=30),
    Flood("heads of pages", heads),
    Flood("conditional requests", conditional_requests),
    Flood("probes", probes),
    Flood("made-up sessions", made_up_sessions),
    Flood("log-outs", log_outs),
    Flood("searches like patterns", searches_like_patterns),
    Flood("documentation", documentation),
    Flood("codes of classes", codes_of_classes),
    Flood("streams opened again", streams_again, at_once=8),
    Flood("senders who hang up", hang_ups, at_once=8),
    Flood("connections opened and left", connections_left, at_once=20, fast=True),
    Flood("bodies that wait", bodies_that_wait, at_once=200),
    Flood("questions", questions),
    Flood("answers to questions", quiz_answers),
    Flood("programs of strangers", programs_of_strangers, PAGES | {"cell"}),
    Flood("colouring bombs", colouring, fast=True),
    Flood("list bombs of a teacher", list_bombs, at_once=60, fast=True),
    Flood("files of a gradebook", gradebook_files),
    Flood("copies of a class", archives_of_copies, at_once=8),
    Flood("long files", long_files),
    Flood("comments", comments),
    Flood("endless loops of a guest", program(_all_functions("while True: pass")), ALL, 20, fast=True),
    Flood("debug prints", program(_all_functions("for k in range(100000): print(a)", "return a[0]")), ALL, 4),
    Flood("memory hogs", program(_all_functions("b = []", "while True: b.append(bytearray(1 << 20))")), ALL, 4),
    Flood("fork bombs", program(FORKS), ALL, 4),
    Flood("floods of output", program(OUTPUT), ALL, 4),
    Flood("floods of threads", program(THREADS), ALL, 4),
    Flood("floods of files", program(DISK), ALL, 4),
    Flood("deep recursion", program(_all_functions("return f(*a)")), ALL, 4),
    Flood("huge answers", program(_all_functions("return [0.0] * 10**6")), ALL, 4),
    Flood("answers of lists of arrays", hostile("output_limit/liste_de_tableaux.py"), ALL, 4),
    Flood("answers of dictionaries", hostile("output_limit/dictionnaires_de_dictionnaires.py"), ALL, 4),
    Flood("prints beside wrong answers", hostile("wrong_answer/affichage_enorme.py"), ALL, 4),
    Flood("counterexamples without end", hostile("wrong_answer/simplification_sans_fin.py"), ALL, 4),
    Flood("long lines", program("x = " + "1+" * 20_000 + "1"), ALL, 4),
    Flood("deep brackets", program("x = " + "(" * 20_000), ALL, 4),
    Flood("endless cells", cells("while True:\n    pass"), ALL, 20, fast=True),
    Flood("cells that hog memory", cells(HOGS), ALL, 8),
    Flood("cells that draw", cells(DRAWINGS), ALL, 8),
    Flood("endless steps", step_loops, ALL, 8),
    Flood("figures", figures, ALL, 8, fast=True),
]
FLOODS = {flood.name: flood for flood in _ROWS}
