"""The steps of a plan, and the folder in which each finished one is kept, so that a render killed halfway goes on.

`passes/` holds one multilayer EXR a step and `index.json`, which says what they were rendered from (a fingerprint of the
scene, the light and the settings) and what each file's content is (size and BLAKE2b digest). A file comes first and its
entry second, both written whole: what is in the index is finished, and a file that no longer fits its entry is damaged
and rendered again.

Channels of a step's file, for the n-th view layer: ``n.GROUP.R``, ``.G``, ``.B`` for every light group, ``n.alpha.V`` with a
transparent film, and where they were asked for the features ``n.guide albedo.R`` ..., ``n.guide normal.X`` ...,
``n.guide index.V``; and which pixels show which object, as cryptomatte (`files.cryptomatte`), in the steps that
`matte_steps` names.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from ..errors import RenderError
from ..files.atomic import UNFINISHED, written_whole
from ..files.image_exr import read_channels
from ..model import FloatArray
from ..render_model import PassImage, PassPlan, RenderStep

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

_FORMAT = "spectral-probe-passes-2"


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
    channels, _ = read_channels(path)
    start = f"{view_layer}."
    own = {name.removeprefix(start): pixels for name, pixels in channels.items() if name.startswith(start)}
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
    """What the index knows of a finished step's file."""

    bytes: int
    digest: str
    seconds: float
    samples: int


@dataclass
class PassFolder:
    """The folder of a render's steps: which are finished, and what they were rendered from.

    Parameters
    ----------
    directory
        The folder.
    fingerprint
        What the steps are rendered from, a digest for each part such as "scene" or "light".
    view_layers
        Names of the view layers in each file, in their order there.
    finished
        Finished steps by name.
    """

    directory: Path
    fingerprint: Mapping[str, str]
    view_layers: tuple[str, ...] = ()
    finished: dict[str, FinishedStep] = field(default_factory=dict)

    def path(self, name: str) -> Path:
        """The file of a step."""
        return self.directory / f"{name}.exr"

    def holds(self, name: str) -> bool:
        """Whether a step is finished and its file is as it was written."""
        entry, path = self.finished.get(name), self.path(name)
        return (
            entry is not None
            and path.is_file()
            and path.stat().st_size == entry.bytes
            and digest_of(path) == entry.digest
        )

    def record(self, name: str, seconds: float, samples: int) -> None:
        """Note that a step's file is written."""
        path = self.path(name)
        self.finished[name] = FinishedStep(path.stat().st_size, digest_of(path), seconds, samples)
        self._write()

    def changes(self, fingerprint: Mapping[str, str]) -> tuple[str, ...]:
        """Parts of a fingerprint that are not those the steps were rendered from."""
        names = dict.fromkeys([*self.fingerprint, *fingerprint])
        return tuple(n for n in names if self.fingerprint.get(n) != fingerprint.get(n))

    def _write(self) -> None:
        content = {
            "format": _FORMAT,
            "fingerprint": dict(self.fingerprint),
            "view_layers": list(self.view_layers),
            "finished": {name: asdict(entry) for name, entry in self.finished.items()},
        }
        with written_whole(self.directory / INDEX_NAME) as temporary:
            temporary.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def open_pass_folder(directory: Path) -> PassFolder | None:
    """The folder as an earlier render left it; None where there is none, or its index is damaged."""
    try:
        content = json.loads((Path(directory) / INDEX_NAME).read_text(encoding="utf-8"))
        if content["format"] != _FORMAT:
            return None
        return PassFolder(
            directory=Path(directory),
            fingerprint={str(k): str(v) for k, v in content["fingerprint"].items()},
            view_layers=tuple(map(str, content["view_layers"])),
            finished={
                str(name): FinishedStep(
                    int(entry["bytes"]), str(entry["digest"]), float(entry["seconds"]), int(entry["samples"])
                )
                for name, entry in content["finished"].items()
            },
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def new_pass_folder(
    directory: Path, fingerprint: Mapping[str, str], view_layers: Iterable[str]
) -> PassFolder:
    """An empty folder: steps of an earlier render in it are removed, lest the two be mixed."""
    directory = Path(directory)
    (directory / INDEX_NAME).unlink(missing_ok=True)  # first: without it no file counts as finished
    for stale in directory.glob("*.exr"):
        stale.unlink()
    return PassFolder(directory, dict(fingerprint), tuple(view_layers))


def remove_unfinished(directory: Path) -> None:
    """Remove what a killed render was writing, in its folder and in that of its passes."""
    for folder in (Path(directory), Path(directory) / "passes"):
        for left in folder.glob(f"{UNFINISHED}*"):
            shutil.rmtree(left, ignore_errors=True)


def digest_of(path: Path) -> str:
    """BLAKE2b digest of a file's content."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=16)).hexdigest()
