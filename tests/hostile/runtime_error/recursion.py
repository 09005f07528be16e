import sys
sys.setrecursionlimit(2**31 - 1)
def repondre(contexte):
    return repondre(contexte) + 1
