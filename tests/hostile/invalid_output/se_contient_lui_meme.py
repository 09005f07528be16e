def repondre(contexte):
    tout = {}
    tout["tout"] = [tout]
    return tout
