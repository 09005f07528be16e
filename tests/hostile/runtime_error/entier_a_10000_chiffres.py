def repondre(contexte):
    return str(10**10000)
