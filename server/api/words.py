"""The HTTP interface in French, for its page: its routes, their parameters, the statuses of their answers."""

ROUTES: dict[tuple[str, str], str] = {
    ("get", "/api/v1/exercises"): "Les exercices servis, dans l’ordre du cours.",
    ("get", "/api/v1/exercises/{module}/{slug}"): (
        "Un exercice : son énoncé (en HTML), le fichier de départ, les limites d’une exécution. "
        "Un exercice sans code vient avec les questions tirées pour ce compte."
    ),
    ("get", "/api/v1/me/export"): "Tout ce qui est gardé de vous, dans une archive ZIP.",
    ("delete", "/api/v1/me"): "Efface le compte, et tout ce qui en dépend. Cela ne se défait pas.",
    ("post", "/api/v1/submissions"): (
        "Envoie un fichier (`code`), ou des réponses (`answers`) pour un exercice sans code : `kind`, dans l’exercice, "
        "dit lequel des deux. La réponse vient aussitôt ; avec `wait`, elle attend le verdict."
    ),
    ("get", "/api/v1/submissions/{submission_id}"): "Un envoi tel qu’il est : en attente, en cours, ou jugé.",
    ("get", "/api/v1/submissions/{submission_id}/events"): (
        "Le même envoi chaque fois qu’il change (événements envoyés par le serveur) ; se termine avec le verdict."
    ),
    ("get", "/api/v1/submissions/{submission_id}/figures/{name}.svg"): "Une figure que le verdict nomme, en SVG.",
    ("get", "/api/v1/submissions/{submission_id}/figures/{name}.png"): "La même, en image de points.",
}
PARAMETERS: dict[str, str] = {
    "module": "le module",
    "slug": "le nom court de l’exercice",
    "submission_id": "l’identifiant reçu à l’envoi (`id`)",
    "name": "le nom de la figure, tel que le verdict le donne (`figure`)",
    "exercise": "l’exercice : `module/nom`",
    "code": "le fichier entier, 64 Kio au plus",
    "answers": "par question : un nombre ou son texte, une lettre, une liste de lettres",
    "password": "le mot de passe du compte",
    "theme": "les couleurs de la figure",
    "wait": "attendre le verdict tant de secondes, 30 au plus",
    "reuse": "si ce compte a déjà envoyé ce code, répondre par cet envoi sans en faire un nouveau",
}
STATUSES: dict[str, str] = {
    "200": "la réponse",
    "204": "c’est fait",
    "202": "reçu : le verdict se lira à l’adresse `url`",
    "400": "la demande est illisible",
    "401": "le jeton manque, ou n’est plus valable",
    "403": "cette action n’est pas permise à ce compte",
    "404": "rien à cette adresse, ou l’envoi de quelqu’un d’autre",
    "413": "le code, ou la demande, est trop long",
    "422": "des données sont refusées : `errors` dit lesquelles",
    "429": "trop d’envois : `Retry-After` dit dans combien de secondes revenir",
    "503": "trop de monde à la fois : `Retry-After` dit quand revenir",
}
#: Words for the types of JSON Schema.
TYPES: dict[str, str] = {
    "string": "texte",
    "number": "nombre",
    "integer": "entier",
    "boolean": "true | false",
    "null": "null",
    "uuid": "identifiant",
    "date-time": "date ISO 8601",
}
ANYTHING = "valeur JSON"
