"""The French README of a personal data archive."""

READ_ME = """Vos données sur Balise
======================

compte.json      qui vous êtes ici, vos sessions ouvertes, vos jetons, la date de votre adresse d’agenda,
                 et les notes envoyées à la plateforme de votre établissement
                 (ni mot de passe, ni jeton, ni adresse : ils ne sont pas gardés, seule leur empreinte l’est)
classes.json     vos classes, ce qui y est noté de vous, les aménagements en vigueur pour vous
notes.json       les notes que des enseignants ont modifiées ou tapées, les absences et les dispenses,
                 et ce que les journaux des classes disent de vous, ou de ce que vous y avez changé
exercices.json   vos bilans, vos tirages et, pour un enseignant, les corrigés ouverts
messages.json    ce que vous avez écrit et ce qu’on vous a écrit sur votre travail,
                 et, pour un enseignant, les phrases que vous gardez
controles.json   les contrôles que vous avez commencés, et ce que vous y avez enregistré
mes_exercices.json  pour un enseignant, les exercices qu’il a écrits, tels qu’il les a tapés
essais/          un dossier par envoi : votre réponse telle que vous l’avez envoyée,
                 et corrections.json, ce qui en a été dit à chaque correction

Ce qu’un contrôle retient encore n’y est pas : refaites cette archive une fois ses résultats publiés.
Les dates sont en temps universel, au format ISO 8601. Les figures des verdicts se redessinent
à partir de ce qu’elles montrent ; chacune se télécharge depuis la page de son essai, où l’on revoit
aussi ce que le code a fait.
"""
