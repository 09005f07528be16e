import resource
def repondre(contexte):
    releves = []
    for genre in (resource.RLIMIT_AS, resource.RLIMIT_CPU, resource.RLIMIT_FSIZE, resource.RLIMIT_NOFILE, resource.RLIMIT_CORE, resource.RLIMIT_NPROC):
        souple, dure = resource.getrlimit(genre)
        if dure == resource.RLIM_INFINITY:
            releves.append(genre)
        try:
            resource.setrlimit(genre, (dure, dure + 1))
        except (OSError, ValueError):
            continue
        releves.append(genre)
    return str(releves) if releves else "rien"
