import sys
def repondre(contexte):
    for nombre in (1e308, -1e308, float("nan"), float("inf"), -0.0, 5e-324, 10**1000, True):
        print(nombre, end=" ")
    print("\x1b]8;;http://example.org\x07lien\x1b]8;;\x07\u200b\u2066\ufeff\U000e0041{% raw %}{{ config }}<img src=x onerror=alert(1)>" + "|" * 100000)
    sys.stderr.write("\ud800\udfff\x9b31m")
    return "rien"
