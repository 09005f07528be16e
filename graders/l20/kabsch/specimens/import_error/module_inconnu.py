import kabsch_tout_fait


def kabsch(P, Q):
    return kabsch_tout_fait.aligner(P, Q)
