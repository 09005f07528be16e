"""`balise doctor`: which walls of the sandbox stand here."""

from argparse import Namespace

from server.sandbox import WallStatus, probe, safe_to_serve

MARKS = {WallStatus.STANDING: "✓", WallStatus.MISSING: "✗", WallStatus.UNAVAILABLE: "–"}
UNSAFE = 1


def run(_arguments: Namespace) -> int:
    reports = probe()
    for report in reports:
        need = "indispensable" if report.required else "souhaitable"
        print(f"  {MARKS[report.status]} {report.name} ({need}) : {report.detail}")
        if report.mend:
            print(f"      remède : {report.mend}")
    if safe_to_serve(reports):
        print("Cette machine peut exécuter le code des étudiants.")
        return 0
    print("Cette machine ne peut PAS exécuter sans danger le code des étudiants.")
    return UNSAFE
