def repondre(contexte):
    ouverts = []
    while True:
        ouverts.append(open("/dev/null"))
