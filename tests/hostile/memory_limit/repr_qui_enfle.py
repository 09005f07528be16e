class Enfle:
    def __repr__(self):
        return "x" * (1 << 24)
def repondre(contexte):
    return len(repr([Enfle()] * 1000))
