"""Contracts of our own for import-linter (see `contract_types` in pyproject.toml)."""

from __future__ import annotations

import sys
from typing import Any

from grimp import ImportGraph
from importlinter import Contract, ContractCheck, fields, output


class AllowListContract(Contract):
    """What a package may import: itself, Python's own library, and the packages that are named; nothing else."""

    type_name = "allow_list"

    package = fields.StringField()
    allowed = fields.ListField(subfield=fields.StringField())

    def check(self, graph: ImportGraph, verbose: bool) -> ContractCheck:
        package: Any = self.package
        allowed: Any = self.allowed
        inside = {package, *graph.find_descendants(package)}
        if len(inside) < 2:
            raise ValueError(f"{package} holds no module: the contract would say nothing")
        known = {*inside, *sys.stdlib_module_names, *allowed}
        foreign = sorted(
            f"{importer} imports {imported}"
            for importer in inside
            for imported in graph.find_modules_directly_imported_by(importer)
            if imported not in known and imported.split(".")[0] not in known
        )
        return ContractCheck(kept=not foreign, metadata={"foreign": foreign})

    def render_broken_contract(self, check: ContractCheck) -> None:
        for line in check.metadata["foreign"]:
            output.print_error(line)
