"""`balise doctor`: which walls of the sandbox stand here."""

from argparse import Namespace

from server.sandbox import WallStatus, probe, safe_to_serve

MARKS = {WallStatus.STANDING: "✓", WallStatus.MISSING: "✗", WallStatus.UNAVAILABLE: "–"}
UNSAFE = 1


def run(_arguments: Namespace) -> int:
    reports = probe()
    for one in reports:
        need = "indispensable" if one.required else "souhaitable"
        print(f"  {MARKS[one.status]} {one.name} ({need}) : {one.detail}")
        if one.mend:
            print(f"      remède : {one.mend}")
    if safe_to_serve(reports):
        print("Cette machine peut exécuter le code des étudiants.")
        return 0
    print("Cette machine ne peut PAS exécuter sans danger le code des étudiants.")
    return UNSAFE
