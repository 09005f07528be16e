# left: depth
def compte(n):
    return 0 if n == 0 else 1 + compte(n - 1)
def suivre():
    assert compte(950) == 950
    return "rien"
