from concurrent.futures import ThreadPoolExecutor
def repondre(contexte):
    with ThreadPoolExecutor(4) as groupe:
        return sum(groupe.map(abs, range(8)))
