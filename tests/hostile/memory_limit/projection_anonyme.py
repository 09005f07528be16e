import mmap
def repondre(contexte):
    morceaux = []
    while True:
        morceaux.append(mmap.mmap(-1, 1 << 24))
