# Seulement ce qui est faux : le reste est la solution.
def __SLUG__(a, b, t):
    return b + t * (a - b)
