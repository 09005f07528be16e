def repondre(contexte):
    return [[[0] * 50] * 50] * 50
