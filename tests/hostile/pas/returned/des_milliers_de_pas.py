# left: steps
def suivre():
    total = 0
    for k in range(100_000):
        total += k
    return "rien"
