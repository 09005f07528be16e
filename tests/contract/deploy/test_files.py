"""The files of `server/deploy/` speak of the service as it is: settings, commands, ports, metrics, privileges."""

from __future__ import annotations

import fnmatch
import json
import re
import shlex
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml

from server.base.files import ROOT
from server.base.settings import OTHER_VARIABLES, Settings, variable_name
from server.base.version import VERSION
from server.board.live import MAX_STREAM_SECONDS
from server.cli import _build_parser
from server.sandbox.child import syscalls
from tests.support.service import Site

DEPLOY = ROOT / "server" / "deploy"
FILES = [path for path in sorted(DEPLOY.rglob("*")) if path.is_file() and "secrets" not in path.parts]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
KNOWN = {variable_name(name) for name in Settings.model_fields} | OTHER_VARIABLES
#: Of the whole machine, or of other processes: no wall is made of them.
DANGEROUS = """
acct add_key bpf chroot clock_settime delete_module fanotify_init finit_module fsconfig fsmount fsopen init_module
io_uring_enter io_uring_register io_uring_setup ioperm iopl kcmp kexec_file_load kexec_load keyctl lookup_dcookie
name_to_handle_at open_by_handle_at perf_event_open pidfd_getfd process_madvise process_vm_readv process_vm_writev
ptrace quotactl reboot request_key setdomainname setns settimeofday swapoff swapon umount uselib userfaultfd vhangup
"""
WALLS = """
clone clone3 landlock_add_rule landlock_create_ruleset landlock_restrict_self mount mount_setattr move_mount open_tree
pidfd_open pivot_root sethostname umount2 unshare
"""


def text(name: str) -> str:
    return (DEPLOY / name).read_text(encoding="utf-8")


@cache
def documents(name: str) -> list[Any]:
    return list(yaml.safe_load_all(text(name)))


def objects(kind: str) -> dict[str, Any]:
    """Of Kubernetes, by their names."""
    files = documents("kubernetes/kustomization.yaml")[0]["resources"]
    found = [one for file in files for one in documents(f"kubernetes/{file}")]
    return {one["metadata"]["name"]: one for one in found if one["kind"] == kind}


def pods() -> dict[str, Any]:
    """What runs Balise, by the name of what starts it: the specification of its pods, and their labels."""
    jobs = {name: one["spec"]["jobTemplate"]["spec"]["template"] for name, one in objects("CronJob").items()}
    return {name: one["spec"]["template"] for name, one in objects("Deployment").items()} | jobs


def compose() -> Any:
    return documents("compose/compose.yaml")[0]


def unit(name: str) -> dict[str, list[str]]:
    """The values of each key of a unit of systemd, in their order."""
    pairs = re.findall(r"^(\w+)=(.*)$", text(f"systemd/{name}"), re.MULTILINE)
    return {key: [value for name, value in pairs if name == key] for key, _ in pairs}


def commands() -> Iterator[tuple[str, list[str]]]:
    """Every command of Balise that something here runs."""
    container = text("container/Containerfile")
    yield "Containerfile", json.loads(re.findall(r"^CMD (\[.*\])$", container, re.MULTILINE)[-1])
    for name, one in compose()["services"].items():
        if str(one["image"]).startswith("balise:"):
            yield f"compose {name}", one["command"]
    for name, one in pods().items():
        yield f"kubernetes {name}", one["spec"]["containers"][0]["args"]
    for name in ("balise.service", "balise-worker@.service", "balise-backup.service"):
        program, *arguments = shlex.split(unit(name)["ExecStart"][0])
        assert program == "/opt/balise/bin/balise"
        yield name, arguments


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(DEPLOY)))
def test_every_setting_that_a_file_names_is_one(path: Path) -> None:
    content = path.read_text(encoding="utf-8")
    named = set(re.findall(r"\bBALISE_[A-Z_]+[A-Z]\b", content))
    secrets = {one.upper() for one in re.findall(r"(?<![\w-])balise_[a-z_]+\b(?=\}|:|,|\]| \")", content)}
    assert named <= KNOWN
    if path.parent.name == "compose":
        assert secrets <= KNOWN
    assert not re.search(r"^\s*(Environment=)?BALISE_(DATABASE_URL|\w*_TOKEN)\s*[=:]\s*\S", content, re.MULTILINE)


def test_there_are_files_and_they_name_settings() -> None:
    assert len(FILES) > 20
    assert sum("BALISE_" in path.read_text(encoding="utf-8") for path in FILES) > 8


def test_the_settings_of_systemd_are_understood_those_that_are_left_out_too(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = re.findall(r"^#?(BALISE_\w+)=(.*)$", text("systemd/balise.env"), re.MULTILINE)
    assert len(lines) > 4
    for name, value in lines:
        monkeypatch.setenv(name, value)
    settings = Settings()
    assert (settings.root_path, settings.trusted_proxies, settings.workers) == ("/balise", ("127.0.0.1",), 2)


@pytest.mark.parametrize(("where", "arguments"), list(commands()), ids=lambda one: one if isinstance(one, str) else "")
def test_every_command_is_one_of_the_command_line(where: str, arguments: list[str]) -> None:
    assert where
    parsed = _build_parser().parse_args(arguments)
    if arguments[0] == "serve":
        assert parsed.port == 8000
        inside = where in {"compose web", "kubernetes web", "Containerfile"}
        assert parsed.host == ("0.0.0.0" if inside else "127.0.0.1"), "of a container, or of the machine alone"


def test_the_image_is_of_this_version_and_has_what_it_needs() -> None:
    version, container = VERSION, text("container/Containerfile")
    assert f"ARG VERSION={version}" in container
    assert compose()["x-balise"]["image"] == f"balise:{version}"
    assert documents("kubernetes/kustomization.yaml")[0]["images"] == [{"name": "balise", "newTag": version}]
    extras = set(re.search(r"ARG EXTRAS=(.*)", container)[1].split(","))  # type: ignore[index]
    assert {"postgresql", "nats", "federation", "traces"} <= extras <= set(PROJECT["project"]["optional-dependencies"])
    python = re.search(r"ARG PYTHON=([\d.]+)", container)
    assert python
    assert tuple(map(int, python[1].split("."))) >= (3, 11)
    copied = re.findall(r"^COPY (?!--from)(\S+) ", container, re.MULTILINE)
    assert all((ROOT / one).exists() for one in copied)
    assert re.findall(r"^USER (.*)$", container, re.MULTILINE) == ["10001:10001"]
    assert "BALISE_DATA_DIR=/data" in container


def test_a_build_gets_what_a_wheel_is_made_of_and_no_more() -> None:
    lines = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()
    rules = [line for line in lines if line and not line.startswith("#")]
    assert rules[0] == "*", "what is not asked for stays out: data, secrets, environments"
    kept = {rule[1:] for rule in rules if rule.startswith("!")}
    packages = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    assert kept == {*packages, "pyproject.toml", "README.md", "LICENSE"}
    left = rules[1 + len(kept) :]
    needed = ["server/deploy/container/entrypoint.sh", "server/frontend/package-lock.json", "server/app.py"]
    assert not [one for one in needed for rule in left if fnmatch.fnmatch(one, rule.replace("**/", "*"))]
    assert not fnmatch.fnmatch("server/deploy/compose/compose.yaml", "server/static")


def calls(profile: Any) -> set[str]:
    return {name for rule in profile["syscalls"] for name in rule["names"] if rule["action"] == "SCMP_ACT_ALLOW"}


def test_the_seccomp_profile_lets_walls_be_made_and_nothing_of_the_machine_be_touched() -> None:
    profile = json.loads(text("container/seccomp.json"))
    allowed = calls(profile)
    assert profile["defaultAction"] == "SCMP_ACT_ERRNO"
    assert profile["defaultErrnoRet"] == 38, "the C library does without what it is told does not exist"
    assert set(WALLS.split()) <= allowed
    assert allowed & set(DANGEROUS.split()) == set()
    names = [name for rule in profile["syscalls"] for name in rule["names"] if "args" not in rule]
    assert len(names) == len(set(names))
    assert all(rule["comment"] for rule in profile["syscalls"])


def test_what_a_student_s_program_may_ask_the_container_lets_through() -> None:
    """Else a program would fail in a container, and nowhere else."""
    tables = " ".join((syscalls.ALLOWED, syscalls.CONDITIONAL, syscalls.FOLDER)).split()
    asked = {entry.partition(":")[0] for entry in tables}
    assert len(asked) > 100
    assert asked - calls(json.loads(text("container/seccomp.json"))) <= {"clone3"}


@pytest.mark.parametrize("name", ["web", "worker"])
def test_a_container_of_compose_has_no_privilege_and_writes_nowhere_but_in_its_volumes(name: str) -> None:
    one = compose()["services"][name]
    assert (one["read_only"], one["user"], one["cap_drop"]) == (True, "10001:10001", ["ALL"])
    assert "cap_add" not in one
    assert "privileged" not in one
    assert "no-new-privileges:true" in one["security_opt"]
    seccomp = next(option.partition("=")[2] for option in one["security_opt"] if option.startswith("seccomp="))
    assert (DEPLOY / "compose" / seccomp).is_file()
    assert "apparmor=balise" in one["security_opt"]
    assert "profile balise " in text("container/apparmor")
    assert [volume.partition(":")[2] for volume in one["volumes"]] == ["/data"]
    assert one["tmpfs"][0].startswith("/tmp:")
    assert one["environment"]["BALISE_SECRETS_DIR"] == "/run/secrets"
    assert {one["mem_limit"], one["pids_limit"], one["stop_grace_period"]}
    assert (DEPLOY / "compose" / one["build"]["context"]).resolve() == ROOT
    assert (ROOT / one["build"]["dockerfile"]).is_file()


def test_the_secrets_of_compose_are_those_that_its_script_makes() -> None:
    made = set(re.findall(r"^keep (\w+) ", text("compose/secrets.sh"), re.MULTILINE))
    asked = {Path(one["file"]).name for one in compose()["secrets"].values()}
    assert asked <= made
    assert all(one["file"].startswith("secrets/") for one in compose()["secrets"].values())
    assert "server/deploy/compose/secrets/" in (ROOT / ".gitignore").read_text(encoding="utf-8")


def test_every_service_of_compose_is_watched_or_says_why_not() -> None:
    services = compose()["services"]
    assert set(services) == {"web", "worker", "postgres", "nats"}
    assert {name for name, one in services.items() if "healthcheck" in one} == {"worker", "postgres", "nats"}
    assert "/healthz" in text("container/Containerfile").split("HEALTHCHECK")[1], "that of `web`"
    assert compose()["networks"]["inside"]["internal"] is True
    assert [name for name, one in services.items() if "ports" in one] == ["web"]
    assert services["web"]["ports"] == ["127.0.0.1:8000:8000"]


@pytest.mark.parametrize("name", pods())
def test_a_pod_has_no_privilege(name: str) -> None:
    spec = pods()[name]["spec"]
    container = spec["containers"][0]
    own = container["securityContext"]
    assert own == {
        "allowPrivilegeEscalation": False,
        "readOnlyRootFilesystem": True,
        "capabilities": {"drop": ["ALL"]},
    }
    whole = spec["securityContext"]
    assert (whole["runAsNonRoot"], whole["runAsUser"], whole["fsGroup"]) == (True, 10001, 10001)
    assert spec["automountServiceAccountToken"] is False
    assert spec["enableServiceLinks"] is False, "else BALISE_… of a Service stops the start"
    if name != "backup":
        assert whole["seccompProfile"] == {"type": "Localhost", "localhostProfile": "balise.json"}
    assert "memory" in container["resources"]["limits"]
    mounted = {one["mountPath"]: one["name"] for one in container["volumeMounts"]}
    assert set(mounted.values()) == {one["name"] for one in spec["volumes"]}
    assert {"/data", "/tmp", objects("ConfigMap")["balise"]["data"]["BALISE_SECRETS_DIR"]} <= set(mounted)


def test_what_kubernetes_selects_is_there() -> None:
    labels = {name: one["metadata"]["labels"] for name, one in pods().items()}
    for kind in ("Deployment", "PodDisruptionBudget"):
        for name, one in objects(kind).items():
            assert one["spec"]["selector"]["matchLabels"].items() <= labels[name].items()
    assert objects("Service")["web"]["spec"]["selector"].items() <= labels["web"].items()
    policies = {name: one["spec"]["podSelector"]["matchLabels"] for name, one in objects("NetworkPolicy").items()}
    assert all(policies["balise"].items() <= one.items() for one in labels.values())
    scaled = [*objects("ScaledObject").values(), *objects("HorizontalPodAutoscaler").values()]
    assert {one["spec"]["scaleTargetRef"]["name"] for one in scaled} == set(objects("Deployment"))
    ports = {one["name"] for one in pods()["web"]["spec"]["containers"][0]["ports"]}
    assert {one["targetPort"] for one in objects("Service")["web"]["spec"]["ports"]} <= ports
    files = documents("kubernetes/kustomization.yaml")[0]["resources"]
    assert {path.name for path in (DEPLOY / "kubernetes").glob("*.yaml")} - {"kustomization.yaml"} == set(files)


def test_probes_ask_what_the_service_answers(site: Site) -> None:
    container = pods()["web"]["spec"]["containers"][0]
    probes = {name: container[name]["httpGet"]["path"] for name in ("startupProbe", "readinessProbe", "livenessProbe")}
    assert probes == {"startupProbe": "/healthz", "readinessProbe": "/readyz", "livenessProbe": "/healthz"}
    assert all(site.client.get(path).status_code in {200, 503} for path in probes.values())


def test_graders_are_scaled_by_what_students_wait_for() -> None:
    layout = pytest.importorskip("server.queue.jetstream.stream_layout", reason="nats-py is not installed")
    trigger = objects("ScaledObject")["worker"]["spec"]["triggers"][0]["metadata"]
    assert trigger["stream"] == layout.STREAM
    assert trigger["consumer"] == layout.JobConsumer("grade", "interactive").consumer_name


@pytest.mark.parametrize("name", ["balise.service", "balise-worker@.service", "balise-backup.service"])
def test_a_unit_keeps_what_walls_are_made_of_and_nothing_else(name: str) -> None:
    found = unit(name)
    on = ("NoNewPrivileges", "PrivateTmp", "PrivateDevices", "ProtectHome", "ProtectKernelModules", "RestrictSUIDSGID")
    assert all(found[key] == ["yes"] for key in on)
    assert (found["ProtectSystem"], found["CapabilityBoundingSet"], found["User"]) == (["strict"], [""], ["balise"])
    walls = name != "balise-backup.service"
    assert walls is not bool({"RestrictNamespaces", "ProtectHostname", "ProtectControlGroups"} & found.keys())
    assert "PrivateUsers" not in found
    if walls:
        assert (found["Delegate"], found["DelegateSubgroup"]) == (["memory pids cpu"], ["service"])
        allowed = " ".join(found["SystemCallFilter"]).split()
        assert {"@system-service", "@mount", "sethostname", "landlock_restrict_self"} <= set(allowed)
    assert found["LoadCredential"] == ["balise:/etc/balise/secrets"]
    assert "BALISE_SECRETS_DIR=%d" in found["Environment"]


def test_proxies_let_through_what_the_service_bounds_and_wait_as_long_as_it_does() -> None:
    most = Settings.model_fields["body_bytes"].default
    snippet = text("proxy/nginx/proxy.conf")
    ingress = objects("Ingress")["web"]["metadata"]["annotations"]
    bounds = [re.search(r"client_max_body_size (\w+);", snippet), re.search(r"max_size (\w+)", text("proxy/Caddyfile"))]
    sizes = [one[1] for one in bounds if one] + [ingress["nginx.ingress.kubernetes.io/proxy-body-size"]]
    assert len(sizes) == 3
    for size in sizes:
        number, unit_of = re.fullmatch(r"(\d+)(\w*)", size).groups()  # type: ignore[union-attr]
        assert most < int(number) * {"m": 2**20, "MB": 10**6}[unit_of] <= 4 * most
    waits = re.search(r"proxy_read_timeout (\d+)s;", snippet)
    assert waits
    assert int(waits[1]) > MAX_STREAM_SECONDS
    assert int(ingress["nginx.ingress.kubernetes.io/proxy-read-timeout"]) > MAX_STREAM_SECONDS
    for header in ("Host $http_host", "X-Forwarded-For $proxy_add_x_forwarded_for", "X-Forwarded-Proto $scheme"):
        assert f"proxy_set_header {header};" in snippet


def test_no_visitor_names_a_request_or_its_trace() -> None:
    """What a trusted proxy lets through is believed."""
    snippet, caddy = text("proxy/nginx/proxy.conf"), text("proxy/Caddyfile")
    assert 'proxy_set_header traceparent "";' in snippet
    assert "proxy_set_header X-Request-ID $request_id;" in snippet
    assert "header_up -traceparent" in caddy
    assert "header_up X-Request-ID {http.request.uuid}" in caddy


def expressions() -> Iterator[str]:
    for group in documents("monitoring/alerts.yml")[0]["groups"]:
        yield from (rule["expr"] for rule in group["rules"])
    for test in documents("monitoring/alerts.test.yml")[0]["tests"]:
        yield from (one["series"] for one in test["input_series"])
    for panel in json.loads(text("monitoring/grafana.json"))["panels"]:
        yield from (target["expr"] for target in panel["targets"])


def test_every_metric_of_the_alerts_and_of_the_dashboard_is_one(site: Site) -> None:
    site.tighten(metrics_token="jeton")
    shown = site.client.get("/metrics", headers={"Authorization": "Bearer jeton"}).text
    types = dict(re.findall(r"^# TYPE (\w+) (\w+)$", shown, re.MULTILINE))
    histograms = [name for name, kind in types.items() if kind == "histogram"]
    known = set(types) | {f"{name}_{end}" for name in histograms for end in ("bucket", "sum", "count")}
    named = {name for one in expressions() for name in re.findall(r"\b((?:balise|process)_\w+)", one)}
    assert named <= known
    ours = {name for name in types if name.startswith("balise_")}
    assert ours - {re.sub("_(bucket|count)$", "", one) for one in named} == set(), "what is measured is shown"


def test_the_dashboard_holds_together() -> None:
    board = json.loads(text("monitoring/grafana.json"))
    panels = board["panels"]
    assert len({one["id"] for one in panels}) == len(panels) > 10
    for one in panels:
        place = one["gridPos"]
        assert place["x"] + place["w"] <= 24
        assert one["title"]
        assert one["targets"]
    assert {"source", "job"} == {one["name"] for one in board["templating"]["list"]}


def test_every_alert_has_its_words_and_a_severity() -> None:
    rules = [rule for group in documents("monitoring/alerts.yml")[0]["groups"] for rule in group["rules"]]
    assert len({rule["alert"] for rule in rules}) == len(rules) > 5
    assert {rule["labels"]["severity"] for rule in rules} == {"page", "ticket"}
    assert all(rule["annotations"]["summary"] for rule in rules)
    named = re.findall(r"server/docs/(\w+\.md)", text("monitoring/alerts.yml"))
    assert named
    assert all((ROOT / "server" / "docs" / name).is_file() for name in named)
