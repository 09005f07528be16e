"""The HTTP interface in French, for its page: its routes, their parameters, the statuses of their answers."""

ROUTES: dict[tuple[str, str], str] = {
    ("get", "/api/v1/classes"): (
        "Vos classes : celles où vous enseignez, assistez, apprenez, demandez à entrer. Un administrateur les a toutes."
    ),
    ("post", "/api/v1/classes"): "Crée une classe, où vous enseignez. Il faut un compte d’enseignant.",
    ("post", "/api/v1/classes/join"): (
        "Entre dans la classe d’un code, ou le demande à ses enseignants. Un invité passe par la page « Rejoindre », "
        "où il dit son nom."
    ),
    ("get", "/api/v1/classes/{class_id}"): "Une classe où vous êtes.",
    ("post", "/api/v1/classes/{class_id}/roster"): (
        "Ajoute à la classe les élèves d’une liste (`nom,prenom,email,identifiant,groupe`, ou les mots du programme de "
        "l’établissement) : CSV, XLSX ou ODS. Une colonne de classes remplit aussi vos autres classes. Avec "
        "`mode=replace`, qui n’y est pas sort de la classe, et `leaving` le nomme. Personne n’est effacé."
    ),
    ("get", "/api/v1/classes/{class_id}/students"): "Les élèves de la classe, dans l’ordre d’une liste de noms.",
    ("put", "/api/v1/classes/{class_id}/marks/{student}/{module}/{slug}"): (
        "Modifie la note d’un élève à un exercice : des points sur 20, ou une dispense, avec le motif, que l’élève "
        "lit. La note automatique est gardée à côté. Avec `assignment`, elle vaut dans ce devoir seulement ; sinon, "
        "dans tous ceux qui demandent l’exercice."
    ),
    ("delete", "/api/v1/classes/{class_id}/marks/{student}/{module}/{slug}"): (
        "Retire la note modifiée de cette portée : ce qu’elle remplaçait vaut de nouveau."
    ),
    ("put", "/api/v1/classes/{class_id}/assignments/{aid}/decisions/{student}"): (
        "Dit d’un devoir entier d’un élève : absent, dispensé, ou 0. Ce qu’il a envoyé reste, et ne compte plus."
    ),
    ("delete", "/api/v1/classes/{class_id}/assignments/{aid}/decisions/{student}"): (
        "Retire cette décision : ce qui a été envoyé compte de nouveau."
    ),
    ("get", "/api/v1/classes/{class_id}/marking"): (
        "Comment comptent dans les moyennes de la classe ce qui n’est pas rendu, un retard refusé, une absence."
    ),
    ("patch", "/api/v1/classes/{class_id}/marking"): (
        "Choisit comment ils comptent : 0 (`zero`), ou pas du tout (`ignore`). Les notes restent, les moyennes sont "
        "refaites."
    ),
    ("get", "/api/v1/classes/{class_id}/columns"): (
        "Les colonnes que les enseignants tapent eux-mêmes (oral, papier, participation), dans l’ordre du carnet."
    ),
    ("post", "/api/v1/classes/{class_id}/columns"): (
        "Ajoute une colonne au carnet, après les autres. Les élèves la voient une fois publiée (`published`)."
    ),
    ("get", "/api/v1/classes/{class_id}/columns/{column_id}"): "Une colonne, avec les notes de tous les élèves.",
    ("patch", "/api/v1/classes/{class_id}/columns/{column_id}"): (
        "Change ce qui est envoyé d’une colonne, et laisse le reste. Les notes restent."
    ),
    ("delete", "/api/v1/classes/{class_id}/columns/{column_id}"): (
        "Supprime une colonne du carnet. Elle est gardée avec ses notes, et se rétablit."
    ),
    ("post", "/api/v1/classes/{class_id}/columns/{column_id}/restore"): "Rétablit une colonne, avec ses notes.",
    ("put", "/api/v1/classes/{class_id}/columns/{column_id}/marks"): (
        "Enregistre les notes envoyées, toutes ou aucune ; celles des autres élèves restent. `version` dit ce que vous "
        "avez lu : si une autre note a été tapée entre-temps, 409."
    ),
    ("get", "/api/v1/classes/{class_id}/gradebook"): (
        "Le carnet de notes : JSON, CSV pour un Excel français, XLSX, ou CSV à importer dans Moodle. Celui de Moodle "
        "n’a que les notes définitives, et laisse de côté qui n’a pas d’adresse ou d’identifiant : "
        "`X-Balise-Left-Out` dit combien."
    ),
    ("get", "/api/v1/classes/{class_id}/audit"): (
        "Le journal de la classe : chaque changement d’une note, d’une date ou d’un droit, du plus récent au plus "
        "ancien ; par qui, quand, avant, après."
    ),
    ("post", "/api/v1/classes/{class_id}/regrades"): (
        "Corrige de nouveau, en arrière-plan, ce qui a été envoyé à un exercice. Rien ne compte avant d’être appliqué."
    ),
    ("get", "/api/v1/classes/{class_id}/regrades/{regrade_id}"): (
        "Où en est une recorrection, et de qui elle change la note : ce qui compte est recorrigé en premier."
    ),
    ("post", "/api/v1/classes/{class_id}/regrades/{regrade_id}/apply"): (
        "Fait compter les nouvelles corrections, toutes à la fois. Sans effet si c’est déjà fait."
    ),
    ("post", "/api/v1/classes/{class_id}/regrades/{regrade_id}/undo"): (
        "Fait compter de nouveau les corrections d’avant, toutes à la fois. Sans effet si rien n’est appliqué."
    ),
    ("put", "/api/v1/classes/{class_id}/names/{module}/{slug}/{group}"): (
        "Nomme une erreur : celle des programmes qui répondent tous de même. Ceux de la classe qui ont ainsi échoué, "
        "et ceux qui échoueront ainsi, l’ont pour diagnostic, « vu par votre enseignant »."
    ),
    ("delete", "/api/v1/classes/{class_id}/names/{module}/{slug}/{group}"): (
        "Retire ce nom : plus personne ne le lit."
    ),
    ("get", "/api/v1/classes/{class_id}/dashboard"): (
        "Les chiffres du tableau de la classe, pour qui y enseigne : élèves et exercices, erreurs reconnues, échecs "
        "sans nom, statistiques des exercices."
    ),
    ("get", "/api/v1/classes/{class_id}/events"): (
        "Ce qui change au tableau (événements `cell` et `counts`, envoyés par le serveur). Se termine au bout de "
        "quelques minutes : on revient."
    ),
    ("post", "/api/v1/classes/{class_id}/assignments"): (
        "Donne un devoir à la classe : des exercices, une ouverture, une date de remise, une fermeture, ce que devient "
        "un retard."
    ),
    ("get", "/api/v1/classes/{class_id}/assignments"): (
        "Les devoirs de la classe, dans l’ordre où ils ouvrent ; à un élève, avec ses dates à lui."
    ),
    ("get", "/api/v1/classes/{class_id}/assignments/{aid}"): "Un devoir ; à un élève, avec ses dates à lui.",
    ("patch", "/api/v1/classes/{class_id}/assignments/{aid}"): (
        "Change ce qui est envoyé d’un devoir, et laisse le reste. Ce que les élèves ont envoyé demeure."
    ),
    ("delete", "/api/v1/classes/{class_id}/assignments/{aid}"): (
        "Retire un devoir, avec ses aménagements. Ce que les élèves ont envoyé demeure."
    ),
    ("post", "/api/v1/classes/{class_id}/assignments/{aid}/exceptions"): (
        "Accorde un aménagement à un élève (`student`) ou à un groupe (`group`) : d’autres dates, plus de temps, une "
        "dispense. La raison n’est montrée qu’à ceux qui enseignent."
    ),
    ("get", "/api/v1/classes/{class_id}/assignments/{aid}/exceptions"): (
        "Les aménagements d’un devoir, du plus ancien au plus récent, ceux qui ont été retirés aussi."
    ),
    ("delete", "/api/v1/classes/{class_id}/assignments/{aid}/exceptions/{eid}"): (
        "Retire un aménagement ; il reste dans la liste, avec la date de son retrait."
    ),
    ("get", "/api/v1/classes/{class_id}/assignments/{aid}/rules"): (
        "Les règles en vigueur pour un élève, et pourquoi : ce qui a été dit de chacune, ce qui l’emporte d’abord. "
        "Un élève lit les siennes."
    ),
    ("get", "/api/v1/exercises"): "Les exercices servis, dans l’ordre du cours.",
    ("get", "/api/v1/exercises/{module}/{slug}"): (
        "Un exercice : son énoncé (en HTML), le fichier de départ, les limites d’une exécution. "
        "Un exercice sans code vient avec les questions tirées pour ce compte."
    ),
    ("get", "/api/v1/me/exercises/{module}/{slug}/last"): "Le dernier fichier que vous avez envoyé à cet exercice.",
    ("get", "/api/v1/me/export"): "Tout ce qui est gardé de vous, dans une archive ZIP.",
    ("delete", "/api/v1/me"): (
        "Efface le compte, et tout ce qui en dépend, une fois son mot de passe donné : un jeton seul ne le peut pas "
        "(403). Cette action est définitive. Un compte qui a composé dans un contrôle non publié n’est effacé qu’à la "
        "publication (202)."
    ),
    ("post", "/api/v1/submissions"): (
        "Envoie un fichier (`code`), ou des réponses (`answers`) pour un exercice sans code : `kind`, dans l’exercice, "
        "dit lequel des deux. La réponse vient aussitôt ; avec `wait`, elle attend le verdict. Pendant un contrôle, "
        "rien n’est dit de ce qui est trouvé avant que l’enseignant publie les résultats : `held` le dit ; avant de "
        "l’avoir commencé, sur sa page, et après l’avoir rendu, l’envoi est refusé (409)."
    ),
    ("get", "/api/v1/submissions/{submission_id}"): (
        "Un envoi tel qu’il est : en attente, en cours, ou jugé. Si un contrôle retient son verdict (`held`), il reste "
        "« en cours » (`running`) et sans verdict jusqu’à la publication des résultats, quoi qu’on ait trouvé."
    ),
    ("get", "/api/v1/submissions/{submission_id}/comments"): (
        "Ce qui est dit d’un envoi, des envois précédents là où c’est encore d’actualité (les lignes sont suivies d’un "
        "envoi à l’autre), et de l’exercice."
    ),
    ("post", "/api/v1/submissions/{submission_id}/comments"): (
        "Commente un envoi, ou pose une question à ses enseignants : sur des lignes (`lines`), sur une vérification "
        "(`check`), sur l’envoi entier ; ou répond dans un fil (`thread`), qui se rouvre s’il était réglé."
    ),
    ("patch", "/api/v1/submissions/{submission_id}/comments/{thread_id}"): "Règle un fil, ou le rouvre.",
    ("get", "/api/v1/submissions/{submission_id}/events"): (
        "Le même envoi chaque fois qu’il change (événements envoyés par le serveur) ; se termine avec le verdict, ou "
        "aussitôt si un contrôle le retient."
    ),
    ("get", "/api/v1/submissions/{submission_id}/figures/{name}.svg"): "Une figure que le verdict nomme, en SVG.",
    ("get", "/api/v1/submissions/{submission_id}/figures/{name}.png"): "La même, en image de points.",
}
PARAMETERS: dict[str, str] = {
    "module": "le module",
    "class_id": "l’identifiant de la classe (`id`)",
    "aid": "l’identifiant du devoir (`id`)",
    "eid": "l’identifiant de l’aménagement (`id`)",
    "group": "un groupe d’élèves de la classe ; d’une erreur, le groupe de programmes que le tableau donne",
    "title": "le titre, de 1 à 200 caractères",
    "exercises": "les exercices du module, dans l’ordre, avec leur coefficient",
    "opens_at": "l’ouverture ; sans elle, maintenant",
    "due_at": "la date limite ; null : aucun retard n’est compté",
    "closes_at": "la fermeture ; null : le devoir reste ouvert",
    "late": "un essai en retard : refusé, accepté et signalé, ou pénalisé en points sur 20 par jour de retard entamé",
    "mode": "entraînement, ou contrôle ; d’une liste : `add` ajoute, `replace` fait aussi sortir qui n’y est pas",
    "counts": "l’essai qui fait la note",
    "weight": "le coefficient, plus grand que 0",
    "hints": "quand les indices sont montrés",
    "diagnosis": "quand le diagnostic est montré",
    "solution": "quand le corrigé est montré",
    "duration_minutes": "la durée d’un contrôle, depuis que l’élève le commence",
    "team_size": "combien d’élèves peuvent rendre ensemble, de 1 à 6",
    "teams_by_students": "les élèves forment aussi les équipes, d’un commun accord",
    "groups": "les groupes à qui le devoir est donné ; aucun : toute la classe",
    "time_factor": "de 1 à 4 : par combien la durée est multipliée",
    "explanation": "ce qui est faux et pourquoi, 4000 caractères au plus",
    "question": "ce qui met sur la voie, 1000 caractères au plus",
    "dry_run": "dire ce que la liste changerait, et ne rien écrire",
    "columns": "comment chaque colonne est lue, dans l’ordre : `nom,prenom,,groupe` (vide : laissée de côté)",
    "first_line": "la ligne du premier élève, avec `columns` ; 0 : celle qui suit les titres",
    "encoding": "comment les accents sont lus ; vide : d’après ce qui en sort",
    "class": "la valeur de la colonne des classes qui est cette classe ; `*` : toutes",
    "only_here": "laisser telles quelles vos autres classes que la liste nomme",
    "slug": "le nom court de l’exercice",
    "student": "l’identifiant de l’élève (`id`) ; pour les règles d’un devoir, vide : soi-même",
    "format": "le format du fichier",
    "identifier": "ce à quoi Moodle reconnaît ses élèves : l’adresse électronique ou l’identifiant",
    "what": "un seul genre de changement",
    "skip": "laisser de côté tant de changements parmi les plus récents",
    "limit": "combien au plus",
    "points": "la note, sur 20 ; ou bien `excused`",
    "excused": "dispenser : cela ne compte dans aucune moyenne",
    "reason": "le motif, que le journal de la classe garde : d’une note, l’élève le lit ; d’un aménagement, non",
    "regrade_id": "l’identifiant de la recorrection (`id`)",
    "policy": "ce qui compte une fois appliqué : la meilleure des deux corrections, ou la nouvelle",
    "assignment": "seulement ce devoir (son `id`) ; sans lui, tous",
    "not_handed_in": "un devoir non rendu",
    "late_refused": "un devoir refusé en retard",
    "absent": "une absence",
    "column_id": "l’identifiant de la colonne (`id`)",
    "deleted": "celles qui sont supprimées",
    "out_of": "le barème : la meilleure note possible",
    "taken_on": "le jour, s’il y en a un",
    "bonus": "les points s’ajoutent tels quels à la moyenne, jusqu’à 20",
    "published": "si les élèves la voient",
    "place": "la place parmi les colonnes, à partir de 0",
    "marks": "les notes : `student`, puis `points` ou `state`, `comment`, `version`",
    "comment": "une remarque que l’élève lit une fois la colonne publiée",
    "unanswered": "un exercice sans réponse, d’un devoir rendu",
    "version": "la version que vous avez lue : 409 si elle a changé depuis",
    "submission_id": "l’identifiant reçu à l’envoi (`id`)",
    "thread_id": "l’identifiant du fil (`id`)",
    "text": "le message, 4000 caractères au plus ; `…` y marque du code",
    "lines": "la première ligne et la dernière, à partir de 1",
    "check": "la vérification du verdict, par son `id`",
    "thread": "le fil auquel on répond, par son `id`",
    "state": "d’un fil, `settled` : il n’y a plus rien à dire, ou `open` ; d’un devoir ou d’une note, absent "
    "(`absent`), dispensé (`excused`), 0 (`zero`), non rendu (`not_handed_in`)",
    "name": "le nom de la figure, tel que le verdict le donne (`figure`)",
    "exercise": "l’exercice : `module/nom`",
    "code": "le fichier entier, 64 Kio au plus ; pour entrer dans une classe, le code de celle-ci",
    "answers": "par question : un nombre ou son texte, une lettre, une liste de lettres",
    "password": "le mot de passe du compte",
    "theme": "les couleurs de la figure",
    "wait": "attendre le verdict tant de secondes, 30 au plus",
    "Idempotency-Key": "un nom que vous donnez à cet envoi : renvoyé sous le même nom, après une coupure, il n’est "
    "gardé qu’une fois",
    "reuse": "si ce compte a déjà envoyé ce code, répondre par cet envoi sans en faire un nouveau",
}
STATUSES: dict[str, str] = {
    "200": "la réponse",
    "201": "c’est créé",
    "204": "c’est fait",
    "202": "reçu : le résultat se lira plus tard, à l’adresse de ce qui est créé",
    "400": "la demande est illisible",
    "401": "le jeton manque, ou n’est plus valable",
    "403": "il manque un droit à ce compte : `detail` le nomme",
    "404": "rien à cette adresse, ou ce qui est à quelqu’un d’autre",
    "409": "l’état de ce qui est là ne le permet pas",
    "413": "le code, ou la demande, est trop long",
    "422": "des données sont refusées : `errors` dit lesquelles",
    "429": "trop d’envois, ou d’essais : `Retry-After` dit dans combien de secondes revenir",
    "503": "trop de monde à la fois, ou la base de données ne répond pas : `Retry-After` dit quand revenir",
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
