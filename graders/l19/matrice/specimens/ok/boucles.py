"""Products written out, and a Gauss-Jordan elimination; lists returned, no numpy."""


def produit(A, B):
    return [[sum(A[i][k] * B[k][j] for k in range(len(B))) for j in range(len(B[0]))] for i in range(len(A))]


def transposee(A):
    return [list(colonne) for colonne in zip(*A)]


def somme(A, B, signe=1):
    return [[a + signe * b for a, b in zip(ligne, autre)] for ligne, autre in zip(A, B)]


def inverse(A):
    n = len(A)
    M = [[float(v) for v in A[i]] + [float(i == j) for j in range(n)] for i in range(n)]
    for c in range(n):
        p = max(range(c, n), key=lambda i: abs(M[i][c]))
        M[c], M[p] = M[p], M[c]
        M[c] = [v / M[c][c] for v in M[c]]
        for i in range(n):
            if i != c:
                M[i] = [v - M[i][c] * w for v, w in zip(M[i], M[c])]
    return [ligne[n:] for ligne in M]


def listes(*tableaux):
    return [[[float(v)] for v in t] if t.ndim == 1 else t.tolist() for t in tableaux]


def predire(x, P, F, Q):
    x, P, F, Q = listes(x, P, F, Q)
    return [v[0] for v in produit(F, x)], somme(produit(produit(F, P), transposee(F)), Q)


def corriger(x, P, z, H, R):
    x, P, z, H, R = listes(x, P, z, H, R)
    PH = produit(P, transposee(H))
    K = produit(PH, inverse(somme(produit(H, PH), R)))
    x = somme(x, produit(K, somme(z, produit(H, x), -1)))
    return [v[0] for v in x], somme(P, produit(K, transposee(PH)), -1)
