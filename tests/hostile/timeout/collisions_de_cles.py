class Cle:
    def __hash__(self):
        return 0
    def __eq__(self, autre):
        return self is autre
def repondre(contexte):
    return len({Cle(): k for k in range(10**6)})
