"""Classes."""

from fastapi import APIRouter

from server.api.documentation import problems
from server.base.errors import NotFound
from server.identity.dependencies import ApiAccount

router = APIRouter(tags=["classes"])


@router.get("/classes/{class_id}/dashboard", responses=problems(401, 404))
def dashboard(class_id: str, _account: ApiAccount) -> dict[str, object]:
    """The figures behind a class's page, for its teachers. This version holds no classes: every id is a 404."""
    raise NotFound(f"La classe « {class_id} » n’existe pas.")
