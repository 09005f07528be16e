"""Finds out which walls stand on this machine, by a real assault on each in a real child.

Where several walls stop the same thing, the others are lifted for the assault, so that the result is about one wall.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from enum import StrEnum

from server.sandbox import messages
from server.sandbox.assaults import ASSAULTS, Assault
from server.sandbox.cgroups import ControlGroupPool, usable_hierarchies
from server.sandbox.faults import ProgramFault, TemplateFault
from server.sandbox.launch import TemplateConfig
from server.sandbox.policy import Policy
from server.sandbox.process import TemplateProcess
from server.sandbox.session import Session


class WallStatus(StrEnum):
    STANDING = "standing"
    MISSING = "missing"
    UNAVAILABLE = "unavailable"


@dataclass(frozen=True)
class WallReport:
    """One assault on one wall: `detail` and `mend` are French; without a `required` wall, serving is not safe."""

    name: str
    status: WallStatus
    detail: str
    required: bool
    mend: str = ""


def probe(*, slow: bool = True) -> list[WallReport]:
    """Probe every wall, in a second or two; without `slow`, skip the assaults that must wait for a limit.

    On the template of submissions: the walls do not depend on the import set, and tests try them with each.
    """
    assaults = [assault for assault in ASSAULTS if slow or not assault.slow]
    with ThreadPoolExecutor(1) as spawner:
        templates = _ProbeTemplates(spawner)
        try:
            for lifted in {assault.masking_walls for assault in assaults}:
                templates.get(lifted, namespaces=False)
            with ThreadPoolExecutor(4) as pool:
                return list(pool.map(lambda assault: _probe_wall(assault, templates), assaults))
        finally:
            templates.close()


def is_safe_to_serve(reports: list[WallReport]) -> bool:
    """Whether every required wall was tried and stands."""
    required = [report for report in reports if report.required]
    return bool(required) and all(report.status == WallStatus.STANDING for report in required)


class _ProbeTemplates:
    """One template for each set of lifted walls."""

    def __init__(self, spawner: ThreadPoolExecutor) -> None:
        self._spawner = spawner
        self._started_templates: dict[tuple[bool, frozenset[str]], TemplateProcess | str] = {}
        usable, self.cgroup_problem = usable_hierarchies()
        self.controllers = frozenset(name for hierarchy in usable for name in hierarchy.controllers)
        self._groups, self._no_groups = ControlGroupPool(usable), ControlGroupPool(())

    def get(self, lifted: frozenset[str], *, namespaces: bool) -> TemplateProcess | str:
        """Return the template, in namespaces where available or required; or the reason why there is none."""
        inside = self._get_or_start(True, lifted)
        return inside if namespaces or isinstance(inside, TemplateProcess) else self._get_or_start(False, lifted)

    def _get_or_start(self, namespaces: bool, lifted: frozenset[str]) -> TemplateProcess | str:
        key = (namespaces, lifted)
        if key not in self._started_templates:
            setting = TemplateConfig({}, "numpy", namespaces, lifted)
            seats = self._no_groups if "cgroup" in lifted else self._groups
            try:
                self._started_templates[key] = TemplateProcess(setting, seats, lambda _: None).start(self._spawner)
            except TemplateFault as error:
                self._started_templates[key] = _last_line(error)
        return self._started_templates[key]

    def close(self) -> None:
        for template in self._started_templates.values():
            if isinstance(template, TemplateProcess):
                template.close()
        self._groups.close()


def _last_line(error: TemplateFault) -> str:
    return str(error).strip().splitlines()[-1]


@contextmanager
def _open_session(template: TemplateProcess, source: str, policy: Policy) -> Iterator[Session]:
    session = Session(template.fork(policy), policy)
    try:
        session.load(source.encode(), "solution.py", None)
        yield session
    finally:
        session.close()


def _probe_wall(assault: Assault, templates: _ProbeTemplates) -> WallReport:
    if assault.controller and assault.controller not in templates.controllers:
        return _wall_report(assault, WallStatus.UNAVAILABLE, templates.cgroup_problem)
    template = templates.get(assault.masking_walls, namespaces=assault.namespaces)
    if isinstance(template, str):
        return _wall_report(assault, WallStatus.UNAVAILABLE, template)
    try:
        crossed = run_assault(assault, template)
    except TemplateFault as error:
        return _wall_report(assault, WallStatus.UNAVAILABLE, _last_line(error))
    except ProgramFault as fault:
        return _wall_report(assault, WallStatus.UNAVAILABLE, fault.message)
    if crossed and assault.namespaces and (refusal := template.greeting["refusal"]):
        crossed = f"{crossed} ({refusal})"
    return _wall_report(assault, WallStatus.MISSING if crossed else WallStatus.STANDING, crossed)


def run_assault(assault: Assault, template: TemplateProcess) -> str:
    """Run the assault; return what it managed to do (French), "" when the wall held, even by ending the program."""
    with ExitStack() as stack:
        argument = assault.argument(stack)
        if assault.accomplice:
            stack.enter_context(_open_session(template, assault.accomplice, assault.policy)).call("prepare", argument)
        session = stack.enter_context(_open_session(template, assault.source, assault.policy))
        try:
            return str(session.call("essai", argument).value)
        except ProgramFault as fault:
            if fault.fatal:
                return ""
            raise


def _wall_report(assault: Assault, status: WallStatus, why: str) -> WallReport:
    detail = f"{assault.detail} : {why}" if why else assault.detail
    mend = "" if status == WallStatus.STANDING else messages.add_no_break_spaces(assault.remedy)
    return WallReport(assault.name, status, messages.add_no_break_spaces(detail), assault.required, mend)
