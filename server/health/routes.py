"""What whoever watches the service asks: an orchestrator, a load balancer, Prometheus."""

from secrets import compare_digest
from typing import Annotated

from fastapi import APIRouter, Depends, Request, Response
from fastapi.responses import JSONResponse

from server.base.errors import NotFound, Unauthorised
from server.base.provided import provided
from server.base.settings import Settings
from server.health.metrics import Metrics
from server.health.readiness import CARRIER, Readiness

router = APIRouter(include_in_schema=False)

SettingsOf = Annotated[Settings, Depends(provided(Settings))]
MetricsOf = Annotated[Metrics, Depends(provided(Metrics))]
ReadinessOf = Annotated[Readiness, Depends(provided(Readiness))]
NO_STORE = {"Cache-Control": "no-store"}
SCHEME = "bearer"


@router.get("/healthz")
async def alive() -> Response:
    """That the process answers: whoever gets no answer starts it again. It asks nothing of the database."""
    return JSONResponse({"status": "ok"}, headers=NO_STORE)


@router.get("/readyz")
def ready(readiness: ReadinessOf) -> Response:
    """Whether to send visitors here: 503 where not, with what is amiss. `degraded`: they may come all the same."""
    checks = readiness.checks()
    amiss = {name for name, state in checks.items() if state != "ok"}
    status = "ok" if not amiss else "degraded" if amiss == {CARRIER} else "unready"
    body = {"status": status, "checks": checks}
    return JSONResponse(body, status_code=503 if status == "unready" else 200, headers=NO_STORE)


@router.get("/metrics")
def metrics(request: Request, settings: SettingsOf, measured: MetricsOf) -> Response:
    """For who shows the token of the settings; without one there, for nobody."""
    if not settings.metrics_token:
        raise NotFound("Les mesures ne sont pas publiées : BALISE_METRICS_TOKEN n’est pas réglé.")
    scheme, _, token = request.headers.get("authorization", "").partition(" ")
    if scheme.lower() != SCHEME or not compare_digest(token.encode(), settings.metrics_token.encode()):
        raise Unauthorised("Le jeton de BALISE_METRICS_TOKEN est attendu dans l’en-tête « Authorization: Bearer … ».")
    content, media_type = measured.exposed()
    return Response(content, media_type=media_type, headers=NO_STORE)
