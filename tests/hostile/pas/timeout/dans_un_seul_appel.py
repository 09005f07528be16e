def suivre():
    return sum(range(10**14))
