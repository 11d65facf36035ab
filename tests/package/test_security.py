"""Nothing that a user opens can run code or reach the network: shipped code holds none of what would let it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

SHIPPED = ("spectral_probe", "operators", "panels", "settings", "assets", "translations")
"""Folders of the extension; the modules beside them count, too, but for run.py, which sets up a developer's checkout."""

SCRIPTS = ("build.py", "collect.py")
"""What makes the library of materials and the translations: not in the zip."""

RUNS_TEXT = {"eval", "exec", "compile", "__import__", "breakpoint", "input"}
"""Built-in functions that run a text, or wait for one."""

UNPACKS_OBJECTS = {
    "pickle",
    "cPickle",
    "_pickle",
    "marshal",
    "shelve",
    "dill",
    "joblib",
    "cloudpickle",
    "torch",
    "dbm",
    "copyreg",
}
NETWORK = {
    "socket", "socketserver", "ssl", "urllib", "urllib3", "http", "requests", "httpx", "aiohttp", "ftplib", "smtplib",
    "telnetlib", "poplib", "imaplib", "nntplib", "xmlrpc", "webbrowser", "asyncio", "paramiko",
}  # fmt: skip
STARTS_PROGRAMS = {"subprocess", "pty", "popen2", "commands"}
FOREIGN_CODE = {"ctypes", "cffi", "code", "codeop", "runpy"}

MAY_IMPORT = {
    ("operators/terminal.py", "ctypes"): "to flush what Blender's C library has buffered for the terminal",
    (
        "spectral_probe/batch_processes.py",
        "subprocess",
    ): "this interpreter again, for each capture of a batch",
}
"""Files that may import what others may not, and why."""


def modules(root: Path) -> Iterator[Path]:
    for folder in SHIPPED:
        yield from (path for path in sorted((root / folder).rglob("*.py")) if path.name not in SCRIPTS)
    yield from (path for path in sorted(root.glob("*.py")) if path.name != "run.py")


def parsed(text: str) -> list[ast.AST]:
    return list(ast.walk(ast.parse(text)))


@pytest.fixture(scope="module")
def shipped(project_root) -> dict[str, list[ast.AST]]:
    """All nodes of every shipped module, by its name in the project."""
    return {
        path.relative_to(project_root).as_posix(): parsed(path.read_text("utf-8"))
        for path in modules(project_root)
    }


def dotted(node: ast.expr) -> str:
    """The name of what is called, such as `numpy.load`."""
    if isinstance(node, ast.Attribute):
        return f"{dotted(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else "?"


def calls(shipped: dict[str, list[ast.AST]]) -> Iterator[tuple[str, str, ast.Call]]:
    for name, nodes in shipped.items():
        for node in nodes:
            if isinstance(node, ast.Call):
                yield f"{name}:{node.lineno}", dotted(node.func), node


def imports(shipped: dict[str, list[ast.AST]]) -> Iterator[tuple[str, str]]:
    """Every module that is imported absolutely, by file."""
    for name, nodes in shipped.items():
        for node in nodes:
            if isinstance(node, ast.Import):
                yield from ((name, one.name) for one in node.names)
            elif isinstance(node, ast.ImportFrom) and not node.level:
                yield name, node.module or ""


def test_there_is_something_to_look_at(shipped):
    assert len(shipped) > 250
    assert {"__init__.py", "spectral_probe/cli.py", "operators/job.py", "panels/main_menu.py"} <= set(shipped)


def test_no_text_is_run(shipped):
    assert [place for place, name, _ in calls(shipped) if name in RUNS_TEXT] == []


def test_nothing_unpacks_objects_or_reaches_the_network_or_starts_programs(shipped):
    refused = UNPACKS_OBJECTS | NETWORK | STARTS_PROGRAMS | FOREIGN_CODE
    found = {(name, module) for name, module in imports(shipped) if module.partition(".")[0] in refused}
    assert found == set(MAY_IMPORT)


LOOKED_UP = {
    "operators/job.py": "the modules that an operator's class names, of this package",
    "spectral_probe/cli.py": "the command line of the extension in the folder above",
}


def test_modules_are_looked_up_by_the_codes_own_names_only(shipped):
    """Two places, which a person has looked at, import by a name that is put together."""
    computed = {
        place.partition(":")[0]
        for place, name, call in calls(shipped)
        if name.endswith("import_module") and not isinstance(call.args[0], ast.Constant)
    }
    assert computed <= set(LOOKED_UP)


def test_no_program_is_started_through_os(shipped):
    refused = ("os.system", "os.popen", "os.exec", "os.spawn", "os.startfile", "os.posix_spawn", "os.fork")
    assert [place for place, name, _ in calls(shipped) if name.startswith(refused)] == []
    assert [
        place for place, _, call in calls(shipped) if any(word.arg == "shell" for word in call.keywords)
    ] == []


def test_yaml_and_arrays_are_read_as_data(shipped):
    """Of YAML only the safe loader and the safe dumper; numpy's own files not at all, since they may hold objects."""
    allowed = {"yaml.safe_load", "yaml.safe_dump"}
    for place, name, call in calls(shipped):
        if name.startswith("yaml."):
            assert name in allowed, place
        assert name not in {"np.load", "numpy.load", "np.fromfile", "numpy.fromfile"}, place
        assert not any(word.arg == "allow_pickle" for word in call.keywords), place


def test_xml_is_read_in_one_place_which_refuses_entities(shipped):
    found = {
        name for name, module in imports(shipped) if module.partition(".")[0] in {"xml", "lxml", "xmltodict"}
    }
    assert found == {"spectral_probe/files/spectrum_file.py"}


def test_no_archive_is_unpacked(shipped):
    archives = {"zipfile", "tarfile", "gzip", "bz2", "lzma"}
    assert [(name, module) for name, module in imports(shipped) if module.partition(".")[0] in archives] == []


def test_blender_files_are_opened_with_their_scripts_off(shipped):
    """Drivers and text blocks of a scene that somebody sent do not run."""
    opened = [(place, call) for place, name, call in calls(shipped) if name.endswith("wm.open_mainfile")]
    assert opened
    for place, call in opened:
        off = [word.value for word in call.keywords if word.arg == "use_scripts"]
        assert len(off) == 1, place
        assert isinstance(off[0], ast.Constant), place
        assert off[0].value is False, place


def test_no_driver_or_handler_is_made_of_an_input(shipped):
    """A driver's expression is code. Handlers are functions of ours, each registered by name in one file."""
    refused = (
        "driver_add",
        "script.python_file_run",
        "text.run_script",
        "script.execute_preset",
        "script.reload",
    )
    assert [place for place, name, _ in calls(shipped) if name.endswith(refused)] == []
    for name, nodes in shipped.items():
        assigned = [
            node
            for node in nodes
            if isinstance(node, ast.Attribute) and node.attr == "use_scripts_auto_execute"
        ]
        expressions = [
            node for node in nodes
            if isinstance(node, ast.Assign) and any(isinstance(t, ast.Attribute) and t.attr == "expression" for t in node.targets)
        ]  # fmt: skip
        assert assigned == [], name
        assert expressions == [], name


def test_the_extension_asks_for_files_only_and_says_why(manifest):
    assert list(manifest["permissions"]) == ["files"]
    assert manifest["permissions"]["files"].strip()


def test_the_walk_would_notice():
    """Each kind of what is refused, found where it is written."""
    text = "import pickle\nfrom urllib.request import urlopen\neval('1')\nos.system('x')\nbpy.ops.wm.open_mainfile()\n"
    tree = {"bad.py": parsed(text)}
    assert [module for _, module in imports(tree)] == ["pickle", "urllib.request"]
    assert [name for _, name, _ in calls(tree)] == ["eval", "os.system", "bpy.ops.wm.open_mainfile"]
