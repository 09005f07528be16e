def repondre(contexte):
    while True:
        pass
