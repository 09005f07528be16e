import multiprocessing
def repondre(contexte):
    with multiprocessing.Pool(4) as groupe:
        return groupe.map(abs, [1, 2])
