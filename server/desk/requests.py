"""Request helpers shared by the pages of a class."""

from typing import Annotated

from fastapi import Query

ShortQuery = Annotated[str, Query(max_length=100)]
GroupQuery = ShortQuery
