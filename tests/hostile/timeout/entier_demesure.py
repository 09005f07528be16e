def repondre(contexte):
    n = 3
    while True:
        n = n * n % (1 << 400000)
