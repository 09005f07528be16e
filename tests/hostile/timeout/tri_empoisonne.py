class Lent:
    def __lt__(self, autre):
        return any(self is autre for _ in iter(int, 1))
def repondre(contexte):
    return sorted([Lent(), Lent()])
