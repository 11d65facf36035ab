"""The words of `render`."""

import argparse
from pathlib import Path

import pytest

from spectral_probe.cli_render import add_words, frame_list
from spectral_probe.cli_swap import swappable_masks
from spectral_probe.errors import RenderError


@pytest.fixture
def parse():
    parser = argparse.ArgumentParser(exit_on_error=False)
    add_words(parser)
    return lambda *words: parser.parse_args(["scene.blend", "--probe", "probe.exr", *words])


@pytest.mark.parametrize(
    ("text", "frames"),
    [("7", (7,)), ("1-3", (1, 2, 3)), ("5,1-2,5", (5, 1, 2)), (" 1 , 3 ", (1, 3)), ("0-0", (0,))],
)
def test_frames(text, frames):
    assert frame_list(text) == frames


@pytest.mark.parametrize("text", ["", "a", "3-1", "1-", "1,,2", "1-99999999", "1.5", "0-9999999"])
def test_no_frames(text):
    with pytest.raises(argparse.ArgumentTypeError, match="no frame"):
        frame_list(text)


def test_defaults(parse):
    words = parse()
    assert (words.passes, words.max_de, words.samples, words.frame, words.frames) == (
        None,
        0.5,
        None,
        None,
        None,
    )
    assert not any((words.full_samples, words.plan_only, words.restart, words.resume, words.no_rgb))


@pytest.mark.parametrize(
    "words",
    [["--restart", "--resume"], ["--plan", "plan.json", "--passes", "4"],
     ["--frame", "1", "--frames", "1-2"], ["--max-de", "0"], ["--max-de", "nan"],
     ["--passes", "0"], ["--samples", "none"], ["--frames", "x"]],
)  # fmt: skip
def test_refused(parse, words):
    with pytest.raises(argparse.ArgumentError):
        parse(*words)


@pytest.mark.parametrize("words", [[], ["--probe", "p.exr", "--world"]])
def test_exactly_one_light(words):
    parser = argparse.ArgumentParser(exit_on_error=False)
    add_words(parser)
    with pytest.raises(argparse.ArgumentError, match=r"--probe|--world"):
        parser.parse_args(["scene.blend", *words])


def test_the_own_world_has_no_regions():
    words = argparse.Namespace(swappable=[("window", Path("window.json"))])
    with pytest.raises(RenderError, match="--swappable"):
        swappable_masks(words, None)
    assert swappable_masks(argparse.Namespace(swappable=[]), None) == {}
