"""`balise doctor`: which walls of the sandbox stand here; with `--cluster`, how what several machines share does."""

from argparse import Namespace

from server.cli import CommandError
from server.cli.configuration import read_settings
from server.sandbox import WallStatus, is_safe_to_serve, probe

MARKS = {WallStatus.STANDING: "✓", WallStatus.MISSING: "✗", WallStatus.UNAVAILABLE: "–"}
UNSAFE = 1


def run(arguments: Namespace) -> int:
    return _report_cluster() if arguments.cluster else _report_walls()


def _report_walls() -> int:
    reports = probe()
    for report in reports:
        need = "indispensable" if report.required else "souhaitable"
        print(f"  {MARKS[report.status]} {report.name} ({need}) : {report.detail}")
        if report.mend:
            print(f"      remède : {report.mend}")
    if is_safe_to_serve(reports):
        print("Cette machine peut exécuter le code des étudiants.")
        return 0
    print("Cette machine ne peut PAS exécuter sans danger le code des étudiants.")
    return UNSAFE


def _report_cluster() -> int:
    settings = read_settings()
    try:
        from server.grading.job_lanes import JOB_LANES
        from server.health.cluster_check import FindingLevel, check_cluster
    except ModuleNotFoundError as error:
        raise CommandError(
            f"il y faut un paquet de plus, que pip install 'balise[nats]' installe ({error})."
        ) from error

    marks = {FindingLevel.good: "✓", FindingLevel.doubtful: "!", FindingLevel.bad: "✗"}
    worst = FindingLevel.good
    for finding in check_cluster(settings, JOB_LANES):
        print(f"  {marks[finding.level]} {finding.subject} : {finding.message}", flush=True)
        if finding.remedy:
            print(f"      remède : {finding.remedy}")
        worst = max(worst, finding.level, key=lambda level: level.value)
    if worst is FindingLevel.bad:
        print("Ce que les machines partagent ne va PAS : voyez les lignes marquées ✗.")
        return UNSAFE
    print(
        "Ce que les machines partagent va bien."
        if worst is FindingLevel.good
        else "Cela marche, à surveiller : lignes « ! »."
    )
    return 0
