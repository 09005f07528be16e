"""As deep as an answer may be, and as wide as fits."""


def repondre(*arguments):
    arbre = 1.5
    for _ in range(12):
        arbre = [arbre, arbre]
    return [arbre]
