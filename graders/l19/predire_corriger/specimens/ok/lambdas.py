gain = lambda v, r: 1 / (1 + r / v)
predire = lambda m, v, u, q: (m + u, v + q)
corriger = lambda m, v, z, r: ((1 - gain(v, r)) * m + gain(v, r) * z, gain(v, r) * r)
