def repondre(contexte):
    return [0] * (contexte["items"] + 1)
