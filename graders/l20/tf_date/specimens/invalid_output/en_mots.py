def interpoler(a, b, part):
    return f"entre {a} et {b}"


def a_la_date(dates, poses, date):
    return "inconnue"


def chercher(messages, cible, source, date):
    return {"parent": cible, "enfant": source}
