def trajectoire(roues, L:
    return roues
