import sys
class Enorme:
    def __repr__(self):
        return "x" * (1 << 24)
    def __str__(self):
        raise ValueError("non")
def repondre(contexte):
    print([Enorme()])
    try:
        print(Enorme())
    except ValueError:
        sys.stdout.writelines("\n" for _ in range(100000))
    sys.stdout.write("\r" * 100000)
    return "rien"
