"""What each kind of job told last, on `WindowManager.spectral_probe_reports`; not saved."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, StringProperty


class SPECTRAL_PROBE_PG_report_line(bpy.types.PropertyGroup):
    """One sentence."""

    kind: EnumProperty(
        name="Kind",
        description="How much it matters",
        items=(
            ("INFO", "Information", "What was done"),
            ("WARNING", "Warning", "What is less than right"),
            ("ERROR", "Error", "Why the job ended"),
        ),
    )
    text: StringProperty(name="Text", description="What was told")


class SPECTRAL_PROBE_PG_job_report(bpy.types.PropertyGroup):
    """The last report of an operator's job; the name is the operator's."""

    title: StringProperty(name="Report", description="Which job it was, how it ended, and how long it took")
    outcome: StringProperty(name="Outcome", description="How it ended, and how long it took")
    longest_step_s: FloatProperty(
        name="Longest Step", description="For how long at most the job held Blender's window", min=0.0
    )
    finished: BoolProperty(name="Finished", description="The job came to its end")
    opened: BoolProperty(name="Open", description="Show what the job told")
    lines: CollectionProperty(type=SPECTRAL_PROBE_PG_report_line)


CLASSES = (SPECTRAL_PROBE_PG_report_line, SPECTRAL_PROBE_PG_job_report)


def attach() -> None:
    """Give the window manager the reports."""
    bpy.types.WindowManager.spectral_probe_reports = CollectionProperty(
        type=SPECTRAL_PROBE_PG_job_report, options={"SKIP_SAVE"}
    )


def detach() -> None:
    """Take them back."""
    del bpy.types.WindowManager.spectral_probe_reports
