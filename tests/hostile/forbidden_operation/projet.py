def repondre(contexte):
    return open(contexte["projet"]).read()
