"""The fixtures of services in processes, on one machine or several, imported only where they are used."""

from __future__ import annotations

import pytest


@pytest.hookimpl(trylast=True)
def pytest_configure(config: pytest.Config) -> None:
    for plugin in ("tests.support.cluster", "tests.support.served"):
        config.pluginmanager.import_plugin(plugin)
