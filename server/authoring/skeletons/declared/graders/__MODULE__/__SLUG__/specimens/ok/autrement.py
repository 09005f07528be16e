from collections import Counter


def __SLUG__(texte):
    return Counter(texte.split())
