def repondre(contexte):
    return sum(range(10**14))
