import occupation_grid

def vers_logodds(p):
    return occupation_grid.logit(p)
