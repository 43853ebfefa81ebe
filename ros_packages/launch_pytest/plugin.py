"""pytest's plug-in: tests beside a launch, as functions (launch_pytest) or files (launch_testing).

It stands alone: pytest without such tests imports nothing of launch.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

_MARKS = {
    "launch_test": "a file of launch_testing's tests",
    "rostest": "as launch_test",
    "launch(fixture, shutdown=False)": "a test beside the launch of a fixture, or behind its end",
}


def pytest_configure(config: pytest.Config) -> None:
    """Make the marks known."""
    for mark, meaning in _MARKS.items():
        config.addinivalue_line("markers", f"{mark}: {meaning}")


def pytest_pycollect_makemodule(module_path: Path, parent: Any) -> Any:
    from launch_pytest.files import launch_tests

    return launch_tests(module_path, parent)


@pytest.hookimpl(tryfirst=True)
def pytest_pycollect_makeitem(collector: Any, name: str, obj: Any) -> Any:
    """Collect coroutines and generators too, where they are marked; pytest refuses them."""
    if not collector.istestfunction(obj, name) or not _is_special(obj):
        return None
    marks = [*getattr(obj, "pytestmark", ()), *collector.iter_markers("launch")]
    return (
        list(collector._genfunctions(name, obj)) if any(m.name == "launch" for m in marks) else None
    )


def _is_special(function: Any) -> bool:
    kinds = (inspect.isgeneratorfunction, inspect.isasyncgenfunction, inspect.iscoroutinefunction)
    return any(kind(function) for kind in kinds)


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef: Any, request: Any) -> Iterator[Any]:
    """Launch what a fixture of `launch_pytest.fixture` returns; its end ends that."""
    described = yield
    options = getattr(fixturedef.func, "launch_pytest_options", None)
    if options is not None:
        from launch_pytest.running import RunningLaunch

        running = RunningLaunch(described, **options)
        request.addfinalizer(running.end)
        fixturedef.running = running
        running.start()
    return described


def _running(request: Any) -> Any:
    """Return the launch that a test's mark names."""
    mark = request.node.get_closest_marker("launch")
    if mark is None or "fixture" not in mark.kwargs:
        raise pytest.UsageError(f"{request.node.name}: valid: @pytest.mark.launch(fixture=NAME)")
    fixture = mark.kwargs["fixture"]
    name = getattr(fixture, "name", None) or fixture.__name__
    request.getfixturevalue(name)
    return request._get_active_fixturedef(name).running


@pytest.fixture
def launch_service(request: Any) -> Any:
    """Return the service that launches."""
    return _running(request).service


@pytest.fixture
def launch_context(request: Any) -> Any:
    """Return the context of the launch."""
    return _running(request).service.context


@pytest.hookimpl(trylast=True)
def pytest_runtest_setup(item: Any) -> None:
    """Launch before the test, whether it asks for the fixture or not."""
    if item.get_closest_marker("launch") is not None and hasattr(item, "_request"):
        item.launched = _running(item._request)


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: Any) -> bool | None:
    """Run a marked test beside the launch, and what follows a `yield` behind its end."""
    launched = getattr(pyfuncitem, "launched", None)
    if launched is None:
        return None
    names = pyfuncitem._fixtureinfo.argnames
    arguments = {name: pyfuncitem.funcargs[name] for name in names}
    if pyfuncitem.get_closest_marker("launch").kwargs.get("shutdown", False):
        launched.end()
    launched.call(pyfuncitem.obj, arguments)
    return True
