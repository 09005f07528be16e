def kabsch(P, Q):
    """La rotation R et la translation t qui amènent les points P
    au plus près des points Q.
    """
    n, d = P.shape
    # À vous de jouer.
    R = np.eye(d)
    t = np.zeros(d)
    return R, t
