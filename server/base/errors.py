"""Errors that a visitor may meet: each class carries its HTTP status and a sentence in French."""

from collections.abc import Mapping
from http import HTTPStatus


class ServiceError(Exception):
    """A refusal with a reason. `slug` names the kind of problem for programs, `detail` tells people."""

    status = HTTPStatus.BAD_REQUEST
    slug = "refus"
    title = "Demande refusée"

    def __init__(self, detail: str, *, headers: Mapping[str, str] | None = None) -> None:
        super().__init__(detail)
        self.detail = detail
        self.headers = dict(headers or {})


class NotFound(ServiceError):
    status = HTTPStatus.NOT_FOUND
    slug = "introuvable"
    title = "Introuvable"


class Unauthorised(ServiceError):
    status = HTTPStatus.UNAUTHORIZED
    slug = "authentification"
    title = "Authentification requise"

    def __init__(self, detail: str) -> None:
        super().__init__(detail, headers={"WWW-Authenticate": 'Bearer realm="balise"'})


class Forbidden(ServiceError):
    status = HTTPStatus.FORBIDDEN
    slug = "interdit"
    title = "Accès refusé"


class TooLarge(ServiceError):
    status = HTTPStatus.REQUEST_ENTITY_TOO_LARGE
    slug = "trop-volumineux"
    title = "Contenu trop volumineux"


class LengthRequired(ServiceError):
    status = HTTPStatus.LENGTH_REQUIRED
    slug = "longueur-inconnue"
    title = "Longueur inconnue"


class RetryLater(ServiceError):
    """Refused for now; `retry_after` is in whole seconds, at least 1."""

    def __init__(self, detail: str, *, retry_after: int) -> None:
        super().__init__(detail, headers={"Retry-After": str(retry_after)})
        self.retry_after = retry_after


class RateLimited(RetryLater):
    """The rate limit is reached."""

    status = HTTPStatus.TOO_MANY_REQUESTS
    slug = "trop-de-demandes"
    title = "Trop de demandes"


class Conflict(ServiceError):
    status = HTTPStatus.CONFLICT
    slug = "conflit"
    title = "Déjà fait"


class WrongMoment(Conflict):
    """What is asked for is of another time: not begun yet, or over."""

    slug = "pas-maintenant"
    title = "Pas maintenant"


class Invalid(ServiceError):
    status = HTTPStatus.UNPROCESSABLE_ENTITY
    slug = "donnees-refusees"
    title = "Données refusées"


class InvalidFields(Invalid):
    """Several fields may be wrong: `problems` maps the name of each to a sentence."""

    def __init__(self, problems: Mapping[str, str]) -> None:
        super().__init__(" ".join(dict.fromkeys(problems.values())))
        self.problems = dict(problems)


class Overloaded(RetryLater):
    """Too many people want the same thing at once."""

    status = HTTPStatus.SERVICE_UNAVAILABLE
    slug = "trop-de-monde"
    title = "Beaucoup de monde"


class Unavailable(RetryLater):
    """What the service stands on does not answer."""

    status = HTTPStatus.SERVICE_UNAVAILABLE
    slug = "indisponible"
    title = "Indisponible un moment"


class StorageFull(RetryLater):
    """The database has no room: nothing was stored."""

    status = HTTPStatus.INSUFFICIENT_STORAGE
    slug = "disque-plein"
    title = "Rien n’a été enregistré"


class InternalFailure(ServiceError):
    """Something of ours went wrong, and another try may succeed."""

    status = HTTPStatus.INTERNAL_SERVER_ERROR
    slug = "incident"
    title = "Incident de notre côté"
