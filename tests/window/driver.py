"""Drives a Blender with a window, from inside it: conftest.py starts Blender with this file as its start script.

A scenario is a file `scenarios/NAME.py` with a generator function `steps(ui)`; `ui` is a `Window`. It yields the seconds
to wait until it goes on, in which Blender redraws and handles events, so that nothing is clicked before it is drawn:

    def steps(ui):
        yield from ui.sidebar("VIEW_3D", "Spectral Probe")
        with ui.step("import"):
            ui.operator("spectral_probe.import_capture", "EXEC_DEFAULT", filepath=ui.words[0])
            yield 0.2
        ui.shot("imported", "VIEW_3D")
        ui.results["views"] = len(ui.scene.spectral_probe.views)

Times of the steps, `ui.results`, what was reported and the longest freeze go into result.json beside the pictures.
"""

from __future__ import annotations

import json
import os
import runpy
import sys
import time
import traceback
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import bpy

EXTENSION = "bl_ext.user_default.spectral_probe"
_HEARTBEAT_S = 0.02
_START_S = 1.5  # the window is drawn before the first step
_LIMIT_S = 270.0  # for the whole scenario; conftest.py gives Blender a little longer


class Window:
    """The window that a scenario drives, and what it writes down."""

    def __init__(self, folder: Path, words: list[str]) -> None:
        self.folder = folder
        self.words = words
        self.results: dict[str, Any] = {}
        self.seconds: dict[str, float] = {}
        self.freezes_s: dict[str, float] = {}
        self._beat_s = time.perf_counter()
        self._longest_s = 0.0

    # ------------------------------------------------------------ where

    @property
    def window(self) -> Any:
        """The first window; file browsers and renders open others after it."""
        return bpy.context.window_manager.windows[0]

    @property
    def scene(self) -> Any:
        """The scene of the window."""
        return self.window.scene

    def area(self, kind: str, window: Any = None) -> Any:
        """The largest area of a kind, such as VIEW_3D."""
        areas = [area for area in (window or self.window).screen.areas if area.type == kind]
        if not areas:
            raise LookupError(f"No area {kind}; make one: ui.show(...)")
        return max(areas, key=lambda area: area.width * area.height)

    def region(self, kind: str, of: str = "WINDOW", window: Any = None) -> Any:
        """A region of the area of a kind: WINDOW, UI (the sidebar), HEADER, ..."""
        return next(region for region in self.area(kind, window).regions if region.type == of)

    def context(self, kind: str | None = "VIEW_3D", of: str = "WINDOW") -> Any:
        """The context of a region, as a button in it or a key over it has."""
        if kind is None:
            return bpy.context.temp_override(window=self.window)
        return bpy.context.temp_override(
            window=self.window, area=self.area(kind), region=self.region(kind, of)
        )

    def show(self, kind: str, instead_of: str) -> Iterator[float]:
        """Turn the area of a kind into another editor, as its menu at the top left does."""
        self.area(instead_of).ui_type = kind
        yield 0.3

    def sidebar(self, kind: str, tab: str = "Spectral Probe") -> Iterator[float]:
        """Open the sidebar of an editor at a tab."""
        self.area(kind).spaces.active.show_region_ui = True
        self.redraw()  # a tab can be chosen only once the sidebar was drawn
        yield 0.3
        self.region(kind, "UI").active_panel_category = tab
        yield 0.3

    def properties(self, tab: str) -> Iterator[float]:
        """Open a tab of the properties editor: WORLD, RENDER, MATERIAL, DATA, ..."""
        self.area("PROPERTIES").spaces.active.context = tab
        yield 0.3

    def open_panels(self, prefix: str = "SPECTRAL_PROBE_PT_") -> None:
        """Have every panel of the extension open from its next drawing on; closed by default, they would not draw."""
        for name in dir(bpy.types):
            panel = getattr(bpy.types, name, None) if name.startswith(prefix) else None
            if panel is not None and "DEFAULT_CLOSED" in getattr(panel, "bl_options", ()):
                bpy.utils.unregister_class(panel)
                panel.bl_options = set(panel.bl_options) - {"DEFAULT_CLOSED"}
                bpy.utils.register_class(panel)

    # ------------------------------------------------------------ what a user does

    def operator(
        self, name: str, execution: str = "INVOKE_DEFAULT", at: str | None = "VIEW_3D", **words: Any
    ) -> set[str]:
        """Call an operator as a button in that editor does, an undo step included; its error is a RuntimeError."""
        module, verb = name.split(".")
        with self.context(at):
            return getattr(getattr(bpy.ops, module), verb)(execution, True, **words)

    def error_of(self, name: str, execution: str = "INVOKE_DEFAULT", **words: Any) -> str:
        """What an operator that cannot go on reports; empty where it raised nothing."""
        try:
            self.operator(name, execution, **words)
        except RuntimeError as report:
            return str(report).strip().removeprefix("Error: ")
        return ""

    def polls(self, name: str, at: str | None = "VIEW_3D") -> bool:
        """Whether the button of an operator is not grey there."""
        module, verb = name.split(".")
        with self.context(at):
            return getattr(getattr(bpy.ops, module), verb).poll()

    def drop(self, paths: list[Path | str], kind: str) -> set[str]:
        """Drop files on an editor, as Blender does once a file manager's drag has ended over it."""
        folders = {str(Path(path).parent) for path in paths}
        if len(folders) != 1:
            raise ValueError("files are dropped out of one folder")
        files = [{"name": Path(path).name} for path in paths]
        return self.operator("wm.drop_import_file", at=kind, directory=folders.pop(), files=files)

    def move(self, x: int, y: int, **modifiers: bool) -> Iterator[float]:
        """Move the mouse; x from the left, y from the bottom, in pixels of the window."""
        self.window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=int(x), y=int(y), **modifiers)
        yield 0.05

    def click(self, x: int, y: int, button: str = "LEFTMOUSE", **modifiers: bool) -> Iterator[float]:
        """Click at a place of the window."""
        yield from self.drag([(x, y)], button, **modifiers)

    def drag(
        self, way: list[tuple[int, int]], button: str = "LEFTMOUSE", **modifiers: bool
    ) -> Iterator[float]:
        """Press at the first place, move along the others, let go at the last."""
        x, y = (int(value) for value in way[0])
        yield from self.move(x, y, **modifiers)
        self.window.event_simulate(type=button, value="PRESS", x=x, y=y, **modifiers)
        yield 0.05
        for place in way[1:]:
            x, y = (int(value) for value in place)
            yield from self.move(x, y, **modifiers)
        self.window.event_simulate(type=button, value="RELEASE", x=x, y=y, **modifiers)
        yield 0.2

    def key(self, name: str, at: str = "VIEW_3D", unicode: str = "", **modifiers: bool) -> Iterator[float]:
        """Press and release a key with the mouse over an editor."""
        region = self.region(at)
        x, y = region.x + region.width // 2, region.y + region.height // 2
        yield from self.move(x, y)
        place = {"x": x, "y": y, **modifiers}
        letter = {"unicode": unicode} if unicode else {}
        self.window.event_simulate(type=name, value="PRESS", **letter, **place)
        yield 0.05
        self.window.event_simulate(type=name, value="RELEASE", **place)
        yield 0.1

    def type_text(self, text: str, at: str = "VIEW_3D") -> Iterator[float]:
        """Type letters, digits and blanks into the field or search that is open."""
        digits = ("ZERO", "ONE", "TWO", "THREE", "FOUR", "FIVE", "SIX", "SEVEN", "EIGHT", "NINE")
        for letter in text:
            name = "SPACE" if letter == " " else digits[int(letter)] if letter.isdigit() else letter.upper()
            yield from self.key(name, at, letter)

    def file_browser(self, folder: Path) -> Generator[float, None, dict[str, Any]]:
        """Point the file browser that is opening to a folder; the context of its buttons."""
        found: list[Any] = []

        def opened() -> bool:
            windows = bpy.context.window_manager.windows
            found[:] = [w for w in windows if any(area.type == "FILE_BROWSER" for area in w.screen.areas)]
            return bool(found)

        yield from self.wait(opened, 20, "a file browser")
        area = self.area("FILE_BROWSER", found[0])
        yield from self.wait(lambda: area.spaces.active.params, 20, "a file browser with a folder")
        area.spaces.active.params.directory = str(folder).encode()
        yield 1.0
        return {
            "window": found[0],
            "area": area,
            "region": self.region("FILE_BROWSER", window=found[0]),
        }

    def choose_folder(self, folder: Path) -> Iterator[float]:
        """Choose a folder in the file browser that is opening."""
        browser = yield from self.file_browser(folder)
        with bpy.context.temp_override(**browser):
            bpy.ops.file.execute()

    # ------------------------------------------------------------ waiting

    def wait(self, until: Callable[[], Any], limit_s: float = 60.0, what: str = "") -> Iterator[float]:
        """Wait until something holds; a TimeoutError after the limit."""
        start_s = time.perf_counter()
        while not until():
            if time.perf_counter() - start_s > limit_s:
                raise TimeoutError(f"{what or until} did not come true in {limit_s:g} s")
            yield 0.1

    @property
    def job(self) -> str:
        """The operator whose job runs; empty when none does."""
        return bpy.context.window_manager.spectral_probe.operator

    def wait_job(self, limit_s: float = 240.0) -> Iterator[float]:
        """Wait until no job of the extension runs."""
        yield 0.2
        yield from self.wait(lambda: not self.job, limit_s, f"the end of the job {self.job}")
        yield 0.2

    # ------------------------------------------------------------ what is written down

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Write down how long a step took, and for how long at most Blender answered nothing in it."""
        start_s = time.perf_counter()
        self._beat_s, self._longest_s = start_s, 0.0
        try:
            yield
        finally:
            end_s = time.perf_counter()
            self.seconds[name] = round(end_s - start_s, 3)
            self.freezes_s[name] = round(max(self._longest_s, end_s - self._beat_s), 3)
            sys.stdout.write(f"Step {name}: {end_s - start_s:.1f} s\n")
            sys.stdout.flush()

    def heartbeat(self) -> float:
        """The timer that notices freezes."""
        now_s = time.perf_counter()
        self._longest_s = max(self._longest_s, now_s - self._beat_s)
        self._beat_s = now_s
        return _HEARTBEAT_S

    def redraw(self) -> None:
        """Draw every window now."""
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                area.tag_redraw()
            with bpy.context.temp_override(window=window):
                bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)

    def shot(self, name: str, kind: str | None = None, of: str | None = None) -> Path:
        """A picture of the screen, of an editor, or of a region of it, as NAME.png in the scenario's folder."""
        self.redraw()
        path = self.folder / f"{name}.png"
        if "XVFB_FBDIR" not in os.environ:
            with self.context(kind):
                (bpy.ops.screen.screenshot_area if kind else bpy.ops.screen.screenshot)(filepath=str(path))
            return path
        import picture  # beside the command that starts the window: software OpenGL makes black screenshots

        place = None if kind is None else self.region(kind, of) if of else self.area(kind)
        box = place and (
            place.x, self.window.height - place.y - place.height, place.width, place.height
        )  # fmt: skip
        picture.grab(str(path), box)
        return path

    def reports(self) -> list[str]:
        """What the operators reported since Blender's start: the lines of the Info editor."""
        area = min(self.window.screen.areas, key=lambda area: area.width * area.height)
        kind = area.ui_type
        area.ui_type = "INFO"
        try:
            space = area.spaces.active
            for name in ("debug", "info", "operator", "warning", "error"):
                setattr(space, f"show_report_{name}", name in ("info", "warning", "error"))
            region = next(region for region in area.regions if region.type == "WINDOW")
            with bpy.context.temp_override(window=self.window, area=area, region=region):
                bpy.ops.info.select_all(action="SELECT")
                bpy.ops.info.report_copy()
        finally:
            area.ui_type = kind
        return [line for line in bpy.context.window_manager.clipboard.splitlines() if line]

    def write(self, error: str | None) -> None:
        """Write result.json; None where nothing went wrong."""
        result = {
            "error": error,
            "seconds": self.seconds,
            "freezes_s": self.freezes_s,
            "results": self.results,
            "reports": self.reports(),
        }
        (self.folder / "result.json").write_text(json.dumps(result, indent=1), "utf-8")
        table = self.table()
        (self.folder / "steps.txt").write_text(table, "utf-8")
        sys.stdout.write(table)

    def table(self) -> str:
        """The steps, and the jobs that ran in them, in lines for people to read."""
        lines = [f"{'step':<28}{'seconds':>10}{'longest gap':>14}"]
        lines += [
            f"{name:<28}{seconds:>10.2f}{self.freezes_s[name]:>14.2f}"
            for name, seconds in self.seconds.items()
        ]
        lines += ["", f"{'job':<48}{'longest step of ours, ms':>26}"]
        lines += [
            f"{report.name:<48}{1000 * report.longest_step_s:>26.0f}"
            for report in getattr(bpy.context.window_manager, "spectral_probe_reports", ())
        ]
        return "\n".join([*lines, ""])


def start(scenario: Path, folder: Path, words: list[str]) -> None:
    """Run a scenario in timers and quit Blender."""
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.use_preferences_save = False
    ui = Window(folder, words)
    steps = runpy.run_path(str(scenario))["steps"](ui)
    start_s = time.perf_counter()

    def finish(error: str | None) -> None:
        try:
            if error is not None:
                ui.shot("error")
            ui.write(error)
        finally:  # whatever went wrong, Blender must not stay open
            with bpy.context.temp_override(window=ui.window):
                bpy.ops.wm.quit_blender()

    def tick() -> float | None:
        error = None
        try:
            if time.perf_counter() - start_s > _LIMIT_S:
                steps.throw(TimeoutError(f"the scenario did not end in {_LIMIT_S:g} s"))
            wait_s = next(steps)
        except StopIteration:
            finish(None)
            return None
        except BaseException:  # noqa: BLE001 - whatever it is, the test must be told
            error = traceback.format_exc()
        if error is not None:
            finish(error)
            return None
        return wait_s or 0.0

    bpy.app.timers.register(ui.heartbeat, persistent=True)
    bpy.app.timers.register(tick, first_interval=_START_S, persistent=True)


if __name__ == "__main__":
    scenario_path, output, *others = sys.argv[sys.argv.index("--") + 1 :]
    start(Path(scenario_path), Path(output), others)
