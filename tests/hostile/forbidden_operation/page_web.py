import urllib.request
def repondre(contexte):
    return urllib.request.urlopen("http://example.org/").read()
