from tf2_ros import Buffer


def interpoler(a, b, part):
    return a


def a_la_date(dates, poses, date):
    return poses[0]


def chercher(messages, cible, source, date):
    return Buffer().lookup_transform(cible, source, date)
