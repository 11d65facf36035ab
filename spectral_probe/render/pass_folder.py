"""The steps of a plan, and the folder in which each finished one is kept, so that a render killed halfway goes on.

`passes/` holds one multilayer EXR a step and, beside each, its manifest: what the file's content is (size and BLAKE2b digest)
and what it depends on (digests of the plan, and of the fingerprint of the scene, the light and the settings). A file comes first
and its manifest second, both written whole: a step with a manifest is finished, and one whose file no longer fits it, or that was
rendered from something else, is rendered again. So several processes and machines finish steps of a frame without sharing a file.

`index.json` is written once, by whoever begins the frame, and last of what that writes: what the steps are rendered from, and
what putting them together needs of the scene (`frame_record`).

Channels of a step's file, for the n-th view layer: ``n.GROUP.R``, ``.G``, ``.B`` for every light group, ``n.alpha.V`` with a
transparent film, and where they were asked for the features ``n.guide albedo.R`` ..., ``n.guide normal.X`` ...,
``n.guide index.V``; and which pixels show which object, as cryptomatte (`files.cryptomatte`), in the steps that
`matte_steps` names.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import RenderError, SpectralDataError
from ..files.atomic import written_whole
from ..files.image_exr import open_rows
from ..files.json_object import UNREADABLE, number, read_object, sentences, table, text, texts, whole
from ..model import FloatArray
from ..render_model import PassImage, PassPlan, RenderStep
from .frame_record import MOST_SAMPLES, FrameRecord, record_from, record_table

FEWEST_SAMPLES = 4
"""Samples below which a part of a render is too noisy: for the ratio of two wavelengths, and for a pass of its own."""

INDEX_NAME = "index.json"

ALPHA = "alpha"
GUIDE_ALBEDO, GUIDE_NORMAL, GUIDE_INDEX = "guide albedo", "guide normal", "guide index"
_GUIDE_CHANNELS = (
    *(f"{GUIDE_ALBEDO}.{c}" for c in "RGB"),
    *(f"{GUIDE_NORMAL}.{c}" for c in "XYZ"),
    f"{GUIDE_INDEX}.V",
)

MOST_VIEW_LAYERS = 1024

_FORMAT = "spectral-probe-passes-3"
_STEP_FORMAT = "spectral-probe-pass-1"


# ---------------------------------------------------------------- steps


def pass_samples(plan: PassPlan, samples: int) -> tuple[int, ...]:
    """Samples of each pass where a full pass has as many as given.

    A pass that is a ratio of another takes at least `FEWEST_SAMPLES`, and all such passes of one reference take as many
    as the largest of them: they are compared with the same first samples of it.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from spectral_probe.render.plan import reference_plan
    >>> plan = replace(reference_plan(), sample_shares=np.array([1.0] + 20 * [1 / 16]), references=(0,) * 21)
    >>> pass_samples(plan, 128)[:3]
    (128, 8, 8)

    Passes that share one sequence have all its samples between them:

    >>> pass_samples(replace(reference_plan(), consecutive=True), 64)[:3]
    (4, 3, 3)
    """
    if plan.consecutive:
        return tuple(max(1, (samples + rest) // plan.passes) for rest in range(plan.passes - 1, -1, -1))
    counts = [max(1, round(samples * float(share))) for share in plan.sample_shares]
    for reference in set(plan.references):
        followers = [p for p, r in enumerate(plan.references) if r == reference and p != reference]
        few = min(max((counts[p] for p in followers), default=1), counts[reference])
        for p in followers:
            counts[p] = min(max(few, FEWEST_SAMPLES), counts[reference])
    return tuple(counts)


def render_steps(plan: PassPlan, samples: int) -> tuple[RenderStep, ...]:
    """The Cycles renders of a plan, in the order in which they are rendered.

    Parameters
    ----------
    plan
        The plan.
    samples
        Samples per pixel of a full pass.

    Returns
    -------
    tuple of RenderStep
        Set by set. The reference of a set comes first: its head, as many samples as the passes compared with it have, and
        its tail, the rest; then those passes. Feature passes are asked for in all that are compared with one another, and in
        the first step.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from spectral_probe.render.plan import reference_plan
    >>> plan = replace(reference_plan(), sample_shares=np.array([1.0] + 20 * [1 / 16]), references=(0,) * 21)
    >>> [(s.name, s.first_sample, s.samples, s.guide) for s in render_steps(plan, 64)[:3]]
    [('pass_00_head', 0, 4, True), ('pass_00_tail', 4, 60, False), ('pass_01', 0, 4, True)]
    """
    counts = pass_samples(plan, samples)
    steps: list[RenderStep] = []
    if plan.consecutive:
        firsts = np.cumsum([0, *counts])
        steps = [RenderStep(f"pass_{p:02d}", p, int(firsts[p]), count) for p, count in enumerate(counts)]
        return (replace(steps[0], guide=True), *steps[1:])
    for light_set in sorted(set(plan.light_sets)):
        for reference in (p for p in range(plan.passes) if _leads(plan, p, light_set)):
            steps += _steps_of(plan, reference, counts)
    return (replace(steps[0], guide=True), *steps[1:])


def _leads(plan: PassPlan, number: int, light_set: int) -> bool:
    return plan.references[number] == number and plan.light_sets[number] == light_set


def _steps_of(plan: PassPlan, reference: int, counts: Sequence[int]) -> list[RenderStep]:
    """The reference's head and tail, and the passes that follow it."""
    followers = [p for p, r in enumerate(plan.references) if r == reference and p != reference]
    name, full = f"pass_{reference:02d}", counts[reference]
    head = counts[followers[0]] if followers else full
    if head == full:
        own = [RenderStep(name, reference, 0, full, guide=bool(followers))]
    else:
        own = [
            RenderStep(f"{name}_head", reference, 0, head, guide=True),
            RenderStep(f"{name}_tail", reference, head, full - head),
        ]
    return own + [RenderStep(f"pass_{p:02d}", p, 0, counts[p], guide=True) for p in followers]


def sequence_samples(plan: PassPlan, samples: int, step: RenderStep) -> int:
    """Samples of the sequence that a step is part of: those of its reference, or of all passes that share one."""
    counts = pass_samples(plan, samples)
    return sum(counts) if plan.consecutive else counts[plan.references[step.pass_number]]


def matte_steps(plan: PassPlan, steps: Sequence[RenderStep]) -> tuple[RenderStep, ...]:
    """Steps whose samples together are a whole sequence: that of the first pass, or that which all passes share.

    What they show of objects' edges is what every full pass shows.

    Examples
    --------
    >>> from spectral_probe.render.plan import reference_plan
    >>> [step.name for step in matte_steps(reference_plan(), render_steps(reference_plan(), 64))]
    ['pass_00']
    """
    return tuple(step for step in steps if plan.consecutive or step.pass_number == steps[0].pass_number)


# ---------------------------------------------------------------- files


def read_pass(path: Path, view_layer: int = 0) -> PassImage:
    """What a step's file holds of a view layer, by the layer's number among those rendered.

    Raises
    ------
    FileFormatError
        If the file is missing or damaged.
    RenderError
        If it holds no such view layer.
    """
    start = f"{view_layer}."
    with open_rows(path) as image:  # of other view layers, and of the objects' shares, nothing is kept
        names_of = {name.removeprefix(start): name for name in image.names if name.startswith(start)}
        read = image.read(list(names_of.values()), slice(0, image.height))
    own = {short: read[name] for short, name in names_of.items()}
    names = dict.fromkeys(name.removesuffix(".R") for name in own if name.endswith(".R"))
    groups = {name: _stacked(own, name, "RGB") for name in names if name != GUIDE_ALBEDO}
    if not groups:
        raise RenderError(f"{path.name} holds no pass of view layer {view_layer + 1}. Render it again.")
    guide = None
    if all(name in own for name in _GUIDE_CHANNELS):
        guide = np.stack([own[name] for name in _GUIDE_CHANNELS], -1)
    return PassImage(groups=groups, alpha=own.get(f"{ALPHA}.V"), guide=guide)


def _stacked(channels: Mapping[str, FloatArray], name: str, letters: str) -> FloatArray:
    return np.stack([channels[f"{name}.{letter}"] for letter in letters], -1)


@dataclass(frozen=True)
class FinishedStep:
    """What the manifest of a finished step says.

    Parameters
    ----------
    bytes, digest
        Size and BLAKE2b digest of its file.
    fingerprint, plan
        Digests of what it was rendered from (`PassFolder.fingerprint_digest`) and of the plan (`PassFolder.plan`).
    seconds, samples
        What it took.
    device
        What Cycles rendered on.
    warnings
        Sentences on what was left out.
    """

    bytes: int
    digest: str
    fingerprint: str
    plan: str
    seconds: float
    samples: int
    device: str
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class PassFolder:
    """The folder of a render's steps: what they are rendered from, and which are finished.

    Parameters
    ----------
    directory
        The folder.
    fingerprint
        What the steps are rendered from, a digest for each part such as "scene" or "light".
    view_layers
        Names of the view layers in each file, in their order there.
    plan
        Digest of the plan's file.
    record
        What putting the steps together needs of the scene.
    """

    directory: Path
    fingerprint: Mapping[str, str]
    view_layers: tuple[str, ...]
    plan: str
    record: FrameRecord

    @property
    def fingerprint_digest(self) -> str:
        """Digest of the whole fingerprint, by which a step tells what it was rendered from."""
        return _digest(json.dumps(sorted(self.fingerprint.items())).encode())

    def path(self, name: str) -> Path:
        """The file of a step."""
        return self.directory / f"{name}.exr"

    def manifest_path(self, name: str) -> Path:
        """What says that a step's file is finished."""
        return self.directory / f"{name}.json"

    def finished(self, name: str) -> FinishedStep | None:
        """The manifest of a step; None where it is not finished, or was rendered from something else."""
        try:
            entry = _finished_step(read_object(self.manifest_path(name)))
        except UNREADABLE:
            return None
        return entry if (entry.fingerprint, entry.plan) == (self.fingerprint_digest, self.plan) else None

    def holds(self, name: str) -> bool:
        """Whether a step is finished and its file is as it was written."""
        entry, path = self.finished(name), self.path(name)
        try:
            return (
                entry is not None
                and path.is_file()
                and path.stat().st_size == entry.bytes
                and digest_of(path) == entry.digest
            )
        except OSError:
            return False

    def finished_names(self) -> tuple[str, ...]:
        """Names of the finished steps, whatever has become of their files since."""
        names = sorted(path.stem for path in self.directory.glob("*.exr"))
        return tuple(name for name in names if self.finished(name) is not None)

    def note(
        self, name: str, seconds: float, samples: int, device: str = "", warnings: Sequence[str] = ()
    ) -> None:
        """Write the manifest of a step whose file is written.

        Raises
        ------
        RenderError
            If the frame was begun anew meanwhile: the step does not belong to it.
        """
        now = open_pass_folder(self.directory)
        if now is None or (now.fingerprint, now.plan) != (self.fingerprint, self.plan):
            raise RenderError(
                f"{self.directory.parent} was begun anew by another process meanwhile, from another scene or with other words. "
                "Start this one again with those of the other, or choose another folder."
            )
        path = self.path(name)
        try:
            size, digest = path.stat().st_size, digest_of(path)
        except OSError as problem:
            raise RenderError(f"{path} cannot be read ({problem.strerror}). Render it again.") from None
        entry = FinishedStep(
            size, digest, self.fingerprint_digest, self.plan, seconds, samples, device, tuple(warnings)
        )
        _write_table(self.manifest_path(name), {"format": _STEP_FORMAT, **asdict(entry)})

    def changes(self, fingerprint: Mapping[str, str]) -> tuple[str, ...]:
        """Parts of a fingerprint that are not those the steps were rendered from."""
        names = dict.fromkeys([*self.fingerprint, *fingerprint])
        return tuple(n for n in names if self.fingerprint.get(n) != fingerprint.get(n))

    def clear(self, *, keep: bool) -> None:
        """Remove the index, and files of steps that do not belong to it; without `keep` all of them, finished ones too."""
        (self.directory / INDEX_NAME).unlink(missing_ok=True)  # first: without it nothing counts
        for path in self.directory.glob("*.exr"):
            if not (keep and self.finished(path.stem)):
                self.manifest_path(path.stem).unlink(missing_ok=True)
                path.unlink()

    def write_index(self) -> None:
        """Write the index, last of what begins a frame."""
        content = {
            "format": _FORMAT,
            "fingerprint": dict(self.fingerprint),
            "view_layers": list(self.view_layers),
            "plan": self.plan,
            "record": record_table(self.record),
        }
        _write_table(self.directory / INDEX_NAME, content)


def open_pass_folder(directory: Path) -> PassFolder | None:
    """The folder of a frame that was begun; None where there is none, or its index is damaged or of another version."""
    directory = Path(directory)
    try:
        content = read_object(directory / INDEX_NAME)
        if content["format"] != _FORMAT:
            return None
        return PassFolder(
            directory=directory,
            fingerprint={name: text(digest) for name, digest in table(content["fingerprint"]).items()},
            view_layers=_layer_names(content["view_layers"]),
            plan=text(content["plan"]),
            record=record_from(content["record"], directory.parent),
        )
    except (*UNREADABLE, SpectralDataError):
        return None


def _layer_names(kept: Any) -> tuple[str, ...]:
    names = texts(kept)
    if not 0 < len(names) <= MOST_VIEW_LAYERS:
        raise ValueError("no view layers, or too many")
    return names


def _finished_step(content: Mapping[str, Any]) -> FinishedStep:
    if content["format"] != _STEP_FORMAT:
        raise ValueError("of another version")
    return FinishedStep(
        bytes=whole(content["bytes"]),
        digest=text(content["digest"]),
        fingerprint=text(content["fingerprint"]),
        plan=text(content["plan"]),
        seconds=number(content["seconds"], 0.0),
        samples=whole(content["samples"], 1, MOST_SAMPLES),
        device=text(content["device"]),
        warnings=sentences(content["warnings"]),
    )


def _write_table(path: Path, content: Mapping[str, Any]) -> None:
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def look_again(directory: Path) -> None:
    """Have a network share forget that files were not in a folder: another machine may have written them since."""
    with suppress(OSError), os.scandir(directory) as entries:
        for _ in entries:
            pass


def digest_of(path: Path) -> str:
    """BLAKE2b digest of a file's content."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=16)).hexdigest()


def _digest(content: bytes) -> str:
    return hashlib.blake2b(content, digest_size=16).hexdigest()
