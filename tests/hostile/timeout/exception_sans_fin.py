class Sans_fin(Exception):
    def __str__(self):
        while True:
            pass
def repondre(contexte):
    raise Sans_fin
