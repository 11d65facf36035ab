"""What every operator of the extension shares: an error the user can put right becomes a report."""

from collections.abc import Callable
from typing import ClassVar

import bpy
from bpy.app.translations import contexts
from bpy.app.translations import pgettext_iface as iface_

from ..spectral_probe.errors import SpectralProbeError
from ..translations import of_core

type OperatorResult = set[str]

FINISHED: OperatorResult = {"FINISHED"}
CANCELLED: OperatorResult = {"CANCELLED"}


class ReportsErrors:
    """Mixin for operators: `execute` calls `run` and reports a `SpectralProbeError`; others propagate."""

    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO"}

    @classmethod
    def label(cls) -> str:
        """The operator's name as buttons show it, in Blender's language."""
        return str(iface_(cls.bl_label, contexts.operator_default))

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Do the work; every operator has its own."""
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        """Called by Blender."""
        return self.reporting(lambda: self.run(context))

    def reporting(self, work: Callable[[], OperatorResult]) -> OperatorResult:
        """The result of `work`, or CANCELLED with a report."""
        try:
            return work()
        except SpectralProbeError as problem:
            self.report({"ERROR"}, of_core(str(problem)))
            return CANCELLED
