def repondre(contexte):
    liste = []
    while True:
        liste.append([0] * 1000)
