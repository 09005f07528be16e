def repondre(contexte):
    ligne = "20/20 " * 20000
    for _ in range(2000):
        print(ligne)
    return "rien"
