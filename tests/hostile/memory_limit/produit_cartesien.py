import itertools
def repondre(contexte):
    return list(itertools.product(range(1000), repeat=4))
