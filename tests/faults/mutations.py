"""Inputs damaged at random, of a fixed seed: cut, flipped, mixed up, and with numbers in their headers that cannot be.

Each function takes a generator of random numbers and the content of a sound file, and returns a damaged one.
"""

from __future__ import annotations

import json
import math
import re
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

type Mutation = Callable[[Random, bytes], bytes]

HUGE = (0, 1, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**24, 65500, 100_000)


# ---------------------------------------------------------------- of any file


def truncated(random: Random, data: bytes) -> bytes:
    """The beginning, of any length."""
    return data[
        : random.choice([random.randrange(len(data)), random.randrange(min(len(data), 64)), len(data) - 1])
    ]


def flipped(random: Random, data: bytes) -> bytes:
    """A few bytes changed, half the time near the beginning."""
    changed = bytearray(data)
    most = len(data) if random.random() < 0.5 else min(len(data), 400)
    for _ in range(random.choice([1, 3, 20, 200])):
        changed[random.randrange(most)] = random.randrange(256)
    return bytes(changed)


def inserted(random: Random, data: bytes) -> bytes:
    """Something put in."""
    at = random.randrange(len(data))
    return data[:at] + random.randbytes(random.choice([1, 2, 16, 5000])) + data[at:]


def deleted(random: Random, data: bytes) -> bytes:
    """Something taken out."""
    at = random.randrange(len(data))
    return data[:at] + data[at + random.choice([1, 2, 16, 1000]) :]


def repeated(random: Random, data: bytes) -> bytes:
    """A piece there twice."""
    first, second = sorted(random.randrange(len(data)) for _ in range(2))
    return data[:second] + data[first:]


def huge_number(random: Random, data: bytes) -> bytes:
    """A number of 2, 4 or 8 bytes, in the header or anywhere, that is far too large, or none."""
    at = random.randrange(min(len(data), random.choice([64, 600, len(data)])))
    kind = random.choice(["<H", ">H", "<I", ">I", "<Q", ">Q"])
    value = random.choice(HUGE) & ((1 << (8 * struct.calcsize(kind))) - 1)
    number = struct.pack(kind, value)
    return data[:at] + number + data[at + len(number) :]


def noise(random: Random, data: bytes) -> bytes:
    """Nothing of it but the length, or the first bytes."""
    kept = random.choice([0, 4, 16, 64])
    return data[:kept] + random.randbytes(max(0, min(len(data), 100_000) - kept))


def empty(_random: Random, _data: bytes) -> bytes:
    """Nothing."""
    return b""


ANY: tuple[Mutation, ...] = (
    truncated, truncated, flipped, flipped, flipped, inserted, deleted, repeated, huge_number, huge_number, noise, empty,
)  # fmt: skip


# ---------------------------------------------------------------- text

_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_WORDS = (
    "nan", "inf", "-inf", "1e400", "-1", "0", "1e308", "-1e308", "9" * 400, "9" * 5000, '"text"', "[]", "{}", "null", "true",
    "[[[[[]]]]]", "1979-05-27", "0x10", "1e-320", "''", "-0.0", "٣", "1_000",
)  # fmt: skip


def number_replaced(random: Random, data: bytes) -> bytes:
    """A number of a text is something else."""
    text = data.decode("utf-8", "surrogateescape")
    found = list(_NUMBER.finditer(text))
    if not found:
        return noise(random, data)
    one = random.choice(found)
    return (text[: one.start()] + random.choice(_WORDS) + text[one.end() :]).encode(
        "utf-8", "surrogateescape"
    )


def word_replaced(random: Random, data: bytes) -> bytes:
    """A text in quotation marks is something else: a path that leads elsewhere, a name too long, no text."""
    text = data.decode("utf-8", "surrogateescape")
    found = list(re.finditer(r'"[^"\n]*"', text))
    if not found:
        return flipped(random, data)
    one = random.choice(found)
    new = random.choice(
        ['""', '"\\u0000"', '"' + "a" * 5000 + '"', '"../../../../etc/passwd"', '"/dev/zero"', '"."', '"/"', "7", "[]",
         "{}", '"\\ud800"', '"nan"', '"NUL"', '"a\\nb"', '"🎈"', '"https://example.com/a.png"', '"//server/share/a.png"']
    )  # fmt: skip
    return (text[: one.start()] + new + text[one.end() :]).encode("utf-8", "surrogateescape")


def line_changed(random: Random, data: bytes) -> bytes:
    """A line gone, twice, endless, or something else."""
    lines = data.split(b"\n")
    at = random.randrange(len(lines))
    match random.randrange(6):
        case 0:
            del lines[at]
        case 1:
            lines.insert(at, lines[at])
        case 2:
            lines[at] = lines[at][:10] + b"9" * 300_000
        case 3:
            lines[at] = random.choice(
                [b"\0" * 20, b"\xff\xfe\xff", b"[[", b"= = =", "\u2028".encode(), b"\r\r\r"]
            )
        case 4:
            lines[at] += random.choice([b",", b",1,2,3", b" = 1", b"[", b"{", b"\x1b[2J"])
        case _:
            random.shuffle(lines)
    return b"\n".join(lines)


def deeply_nested(random: Random, data: bytes) -> bytes:
    """Brackets beyond any stack."""
    depth = random.choice([200, 2000, 100_000])
    match random.randrange(4):
        case 0:
            return b"[" * depth
        case 1:
            return b'{"a":' * depth
        case 2:
            return b"a = " + b"[" * depth + b"\n" + data
        case _:
            return b"[" + b".".join([b"a"] * depth) + b"]\nb = 1\n" + data


TEXT: tuple[Mutation, ...] = (
    *ANY, number_replaced, number_replaced, number_replaced, word_replaced, word_replaced, line_changed, line_changed,
    deeply_nested,
)  # fmt: skip

_VALUES: tuple[Any, ...] = (
    None, True, -1, 0, 1e308, -1e308, math.nan, math.inf, 10**400, "text", "", [], {}, [[]], [None], "../../x", 0.5, 3, 10**9,
    {"a": 1}, [1, 2, 3], [[1, 2], [3]], "1e400", -(10**18), 1e-320, [0] * 61, [[0] * 61] * 3, "\ud800", "nan",
)  # fmt: skip


def json_changed(random: Random, data: bytes) -> bytes:
    """Some values of a JSON document are others, or gone."""
    try:
        document = json.loads(data)
    except ValueError:
        return number_replaced(random, data)
    for _ in range(random.choice([1, 1, 1, 3])):
        document = _changed(random, document)
    return json.dumps(document).encode()


def _changed(random: Random, value: Any) -> Any:
    """The value with something in it changed: it, or what it holds, an equal chance on every level."""
    if isinstance(value, dict) and value and random.random() < 0.9:
        key = random.choice(list(value))
        changed = dict(value)
        gone = changed.pop(key)
        return changed if random.random() < 0.15 else changed | {key: _changed(random, gone)}
    if isinstance(value, list) and value and random.random() < 0.8:
        at = random.randrange(len(value))
        one = random.choice([[], [value[at]] * 2, *[[_changed(random, value[at])]] * 4])
        return [*value[:at], *one, *value[at + 1 :]]
    if isinstance(value, int) and not isinstance(value, bool) and random.random() < 0.4:
        return random.choice([value + 1, value - 1, -value, 1000 * value, 2**31, 2**63, 2**64])
    return random.choice(_VALUES)


JSON: tuple[Mutation, ...] = (*TEXT, *[json_changed] * 14)


# ---------------------------------------------------------------- OpenEXR


def exr_window(random: Random, data: bytes) -> bytes:
    """Another data or display window."""
    name = random.choice([b"dataWindow\0box2i\0", b"displayWindow\0box2i\0"])
    window = [random.choice([0, 1, 7, 63, 4095, 16383, 2**20, 2**31 - 1, -1, -(2**31)]) for _ in range(4)]
    return _exr_value(data, name, struct.pack("<4i", *window))


def exr_attribute(random: Random, data: bytes) -> bytes:
    """Another length, kind or value of an attribute."""
    found = list(re.finditer(rb"[A-Za-z]{3,40}\0[a-z0-9]{3,20}\0", data[:20_000]))
    if not found:
        return flipped(random, data)
    one = random.choice(found)
    at = one.end() if random.random() < 0.5 else one.end() + 4
    value = random.choice(
        [struct.pack("<I", random.choice(HUGE)), random.randbytes(4), b"\0\0\0\0", b"\xff" * 8]
    )
    return data[:at] + value + data[at + len(value) :]


def exr_channels(random: Random, data: bytes) -> bytes:
    """Another kind, sampling or name of a channel."""
    at = data.find(b"channels\0chlist\0") + 20
    end = data.find(b"\0", at)
    field = end + 1 + random.choice([0, 8, 12])
    value = struct.pack("<i", random.choice([0, 1, 2, 3, -1, 2**31 - 1]))
    if random.random() < 0.3:
        return data[:at] + random.randbytes(end - at).replace(b"\0", b"x") + data[end:]
    return data[:field] + value + data[field + 4 :]


def exr_compression(random: Random, data: bytes) -> bytes:
    """Another compression than the blocks have."""
    return _exr_value(data, b"compression\0compression\0", bytes([random.randrange(16)]))


def exr_flags(random: Random, data: bytes) -> bytes:
    """Tiled, deep, of several parts, of another version: or so it says."""
    return (
        data[:4]
        + struct.pack("<I", 2 | random.choice([0x200, 0x400, 0x800, 0x1000, 0x1800, 0xFF00, 1]))
        + data[8:]
    )


def exr_offsets(random: Random, data: bytes) -> bytes:
    """Another entry of the table of blocks, which begins after the header."""
    _, at = _exr_header(data)
    value = struct.pack("<Q", random.choice([0, 8, len(data), 2**63, 2**40, len(data) - 9, at, at + 8]))
    return data[:at] + value + data[at + 8 :]


def exr_text(random: Random, data: bytes) -> bytes:
    """What stands in the header as JSON, changed; the table of blocks follows, so that the rest is sound."""
    attributes, end = _exr_header(data)
    texts = [(start, length) for start, length in attributes if data[start : start + 1] == b"{"]
    if not texts:
        return exr_attribute(random, data)
    start, length = random.choice(texts)
    how = random.choice(
        [json_changed, json_changed, json_changed, number_replaced, flipped, truncated, deeply_nested]
    )
    new = how(random, data[start : start + length])
    moved, table, first = len(new) - length, [], len(data)
    while end + 8 * len(table) < first:
        (offset,) = struct.unpack_from("<Q", data, end + 8 * len(table))
        first = min(first, offset)
        table.append(struct.pack("<Q", offset + moved))
    head = data[: start - 4] + struct.pack("<I", len(new)) + new + data[start + length : end]
    return head + b"".join(table) + data[end + 8 * len(table) :]


def _exr_header(data: bytes) -> tuple[list[tuple[int, int]], int]:
    """Where the values of the attributes are and how long, and where the header ends, of a sound file of one part."""
    at, found = 8, []
    while data[at]:
        at = data.index(b"\0", data.index(b"\0", at) + 1) + 1
        (length,) = struct.unpack_from("<I", data, at)
        found.append((at + 4, length))
        at += 4 + length
    return found, at + 1


def _exr_value(data: bytes, name: bytes, value: bytes) -> bytes:
    at = data.find(name)
    if at < 0:
        return data[: len(data) // 2]
    start = at + len(name) + 4
    return data[:start] + value + data[start + len(value) :]


EXR: tuple[Mutation, ...] = (
    *ANY, exr_window, exr_window, exr_window, exr_attribute, exr_attribute, exr_attribute, exr_channels, exr_channels,
    exr_compression, exr_flags, exr_offsets, exr_text, exr_text, exr_text, exr_text, exr_text, exr_text,
)  # fmt: skip


# ---------------------------------------------------------------- photographs


def tiff_entry(random: Random, data: bytes) -> bytes:
    """An entry of a directory with another tag, kind, count or value; or a directory that follows itself."""
    order = "<" if data[:2] == b"II" else ">"
    (start,) = struct.unpack_from(f"{order}I", data, 4)
    (count,) = struct.unpack_from(f"{order}H", data, start)
    changed = bytearray(data)
    if random.random() < 0.15:
        struct.pack_into(
            f"{order}I", changed, start + 2 + 12 * count, random.choice([start, 4, 8, 2**32 - 1, len(data)])
        )
        return bytes(changed)
    at = start + 2 + 12 * random.randrange(count)
    match random.randrange(4):
        case 0:
            struct.pack_into(
                f"{order}H",
                changed,
                at,
                random.choice([256, 257, 258, 259, 277, 330, 34665, 50706, 273, 700]),
            )
        case 1:
            struct.pack_into(f"{order}H", changed, at + 2, random.randrange(20))
        case 2:
            struct.pack_into(f"{order}I", changed, at + 4, random.choice(HUGE))
        case _:
            struct.pack_into(
                f"{order}I", changed, at + 8, random.choice([*HUGE, start, 8, len(data), len(data) - 1])
            )
    return bytes(changed)


def png_header(random: Random, data: bytes) -> bytes:
    """Another size, depth or kind in a PNG's header, its checksum set right."""
    head = bytearray(data[12:29])
    match random.randrange(3):
        case 0:
            struct.pack_into(">I", head, random.choice([4, 8]), random.choice(HUGE))
        case 1:
            head[12] = random.choice([1, 2, 4, 8, 16, 32, 0])
        case _:
            head[random.choice([13, 14, 15, 16])] = random.randrange(8)
    return data[:12] + bytes(head) + struct.pack(">I", zlib.crc32(bytes(head))) + data[33:]


def png_chunk(random: Random, data: bytes) -> bytes:
    """A further chunk: a profile or a text that unpacks to very much, or a kind nobody knows."""
    bomb = zlib.compress(bytes(random.choice([10, 80_000_000])), 9)
    kind, content = random.choice(
        [(b"iCCP", b"p\0\0" + bomb), (b"zTXt", b"t\0\0" + bomb), (b"iTXt", b"t\0\1\0\0\0" + bomb), (b"qqQq", bomb[:30]),
         (b"gAMA", b"\0\0\0\0"), (b"cHRM", bytes(32)), (b"eXIf", random.randbytes(40)), (b"tRNS", b"\0"), (b"PLTE", b"")]
    )  # fmt: skip
    chunk = struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    return data[:33] + chunk + data[33:]


def jpeg_frame(random: Random, data: bytes) -> bytes:
    """Another size or number of components in a JPEG's frame header, or another length of a segment."""
    at = next((data.find(mark) for mark in (b"\xff\xc0", b"\xff\xc2") if data.find(mark) > 0), 2)
    changed = bytearray(data)
    match random.randrange(4):
        case 0:
            struct.pack_into(
                ">H", changed, at + random.choice([5, 7]), random.choice([0, 1, 65535, 65500, 30000])
            )
        case 1:
            changed[at + 9] = random.randrange(256)
        case 2:
            changed[at + 11] = random.randrange(256)
        case _:
            struct.pack_into(">H", changed, random.choice([at + 2, 4]), random.choice([0, 1, 2, 65535]))
    return bytes(changed)


def hdr_size(random: Random, data: bytes) -> bytes:
    """Another resolution in a Radiance picture."""
    sizes = ["0", "1", "-5", "65535", "99999", "2147483648", "9" * 30, "x", "4294967297"]
    line = f"{random.choice(['-Y', '+Y', '+X', '-X'])} {random.choice(sizes)} +X {random.choice(sizes)}\n"
    return re.sub(rb"-Y \d+ \+X \d+\n", line.encode(), data)


PHOTOGRAPH: dict[str, tuple[Mutation, ...]] = {
    ".dng": (*ANY, *[tiff_entry] * 12),
    ".tif": (*ANY, *[tiff_entry] * 12),
    ".png": (*ANY, *[png_header] * 6, *[png_chunk] * 6),
    ".jpg": (*ANY, *[jpeg_frame] * 8),
    ".hdr": (*ANY, *[hdr_size] * 6),
    ".exr": EXR,
}
_TEXTS = (".toml", ".csv", ".txt", ".spd", ".spdx", ".tsv")


def mutations_of(path: Path) -> tuple[Mutation, ...]:
    """What may happen to a file, by its ending."""
    if path.suffix == ".json":
        return JSON
    return TEXT if path.suffix in _TEXTS else PHOTOGRAPH[path.suffix]
