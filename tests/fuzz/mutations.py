"""Damage to files, seeded: the same file, kind and seed give the same bytes.

Text is damaged as text (numbers, words, lines, nesting), containers inside as well (the JSON of a binary glTF file, the
layers of a USD package), and everything as bytes.
"""

import io
import random
import re
import struct
import zipfile
from collections.abc import Callable, Sequence

from tests.fuzz.containers import pack_glb, pack_usdz, split_glb

__all__ = ["mutate"]

Mutator = Callable[[random.Random, bytes], bytes]

_MOST_BYTES = 400_000  # of a mutation: what grows should not make the run slow by its size alone
_DEEP = (3, 10, 40, 100, 300, 600, 600, 2_000, 12_000)  # levels of nesting; USD's parser takes seconds over the last
_TOKEN = re.compile(rb"[A-Za-z_:][A-Za-z0-9_:.]*|[-+]?[0-9][0-9.eE+-]*|[^\sA-Za-z0-9]")
_NUMBER = re.compile(rb"(?<![A-Za-z_0-9.])[-+]?[0-9][0-9.eE+-]*")
_BAD_NUMBERS = (
    *(b"nan", b"NaN", b"inf", b"-inf", b"1e308", b"-1e308", b"1e39", b"3.4028235e38", b"1e-320", b"-0.0", b"0", b"-1"),
    *(b"1e400", b"99999999", b"4294967296", b"18446744073709551616", b"9" * 400, b"0x10", b"1_000", b"1,5", b"--1"),
    *(b"true", b"null", b"None", b"", b"1.5.5", "١".encode(), "²".encode()),
)
_BAD_BYTES = (
    b"\0",
    b"\xff",
    b"\xef\xbb\xbf",
    b"\r",
    b"\n\n",
    b"\t",
    b'"',
    b"{",
    b"}",
    b"[",
    b"]",
    b"(",
    b")",
    b"#",
    b"\xc3\x28",
)
_INTEGERS = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 2**62, 2**63, 2**64 - 1)
_FLOATS = (float("nan"), float("inf"), -float("inf"), 1e38, -1e38, 1e-45, 0.0)

# Opening and closing of one more level, and the text a level goes behind.
_NESTS: dict[str, tuple[tuple[bytes, bytes, bytes], ...]] = {
    "bvh": ((b"\nJOINT x\n{\nOFFSET 0 1 0\nCHANNELS 0\n", b"}\n", b"CHANNELS"), (b"{", b"}", b"{")),
    "asf": (
        (b"\nbegin\n", b"\nend\n", b":bonedata"),
        (b"(", b")", b"limits"),
        (b"\nbegin\n", b"\nend\n", b":hierarchy"),
    ),
    "amc": ((b"(", b")", b"root"), (b":DEGREES\n", b"", b":DEGREES")),
    "gltf": ((b"[", b"]", b":"), (b'{"a":', b"}", b":"), (b"[", b",0]", b"[")),
    "usda": (
        (b'\ndef Scope "x"\n{\n', b"\n}\n", b"{"),
        (b'\ndef SkelRoot "x"\n{\n', b"\n}\n", b"}"),
        (b"(", b")", b"="),
        (b"[", b"]", b"="),
        (b"{", b"}", b"="),
        (b"\n(\ncustomData = {\ndictionary a = {\n", b"\n}\n}\n)\n", b'"'),
        (b"dictionary a = {\n", b"}\n", b"customLayerData = {"),
    ),
}
_TEXT = {"bvh", "asf", "amc", "gltf", "usda"}


def mutate(data: bytes, kind: str, rng: random.Random) -> bytes:
    """Damage a file in one to three ways.

    Parameters
    ----------
    data
        A valid file.
    kind
        bvh, asf, amc, gltf, glb, usda, usdc or usdz.
    rng
        Decides everything.
    """
    inside = {"glb": _mutate_glb, "usdz": _mutate_usdz}.get(kind)
    if inside is not None and rng.random() < 0.6:
        return inside(data, rng)
    for _ in range(rng.choice((1, 1, 2, 3))):
        data = _mutate_once(data, kind, rng)[:_MOST_BYTES]
    return data


def _mutate_once(data: bytes, kind: str, rng: random.Random) -> bytes:
    if kind not in _TEXT or rng.random() < 0.2:
        return rng.choice(_BINARY)(rng, data)
    if rng.random() < 0.1:
        return _nest(rng, data, _NESTS[kind])
    return rng.choice(_TEXTUAL)(rng, data)


def _mutate_glb(data: bytes, rng: random.Random) -> bytes:
    document, binary = split_glb(data)
    if rng.random() < 0.7:
        document = mutate(document, "gltf", rng)
    else:
        binary = _mutate_once(binary, "bytes", rng)
    return pack_glb(document, binary)


def _mutate_usdz(data: bytes, rng: random.Random) -> bytes:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        entries = [(name, archive.read(name)) for name in archive.namelist()]
    damaged = rng.randrange(len(entries)) if rng.random() < 0.3 else 0
    name, content = entries[damaged]
    kind = "usda" if content.startswith(b"#usda") else "usdc" if content.startswith(b"PXR-USDC") else "bytes"
    entries[damaged] = (name, mutate(content, kind, rng))
    return pack_usdz(entries)


def _span(rng: random.Random, data: bytes, most: int = 64) -> tuple[int, int]:
    start = rng.randrange(len(data) + 1)
    return start, min(len(data), start + rng.randint(1, most))


def _truncate(rng: random.Random, data: bytes) -> bytes:
    return data[: rng.randrange(len(data) + 1)]


def _flip_bits(rng: random.Random, data: bytes) -> bytes:
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 4, 32)) if out else 0):
        out[rng.randrange(len(out))] ^= 1 << rng.randrange(8)
    return bytes(out)


def _overwrite(rng: random.Random, data: bytes) -> bytes:
    start, end = _span(rng, data)
    return data[:start] + rng.choice((b"\0", b"\xff", rng.randbytes(1))) * (end - start) + data[end:]


def _delete_span(rng: random.Random, data: bytes) -> bytes:
    start, end = _span(rng, data)
    return data[:start] + data[end:]


def _repeat_span(rng: random.Random, data: bytes) -> bytes:
    start, end = _span(rng, data)
    return data[:start] + data[start:end] * rng.choice((2, 2, 3, 1000)) + data[end:]


def _insert_bytes(rng: random.Random, data: bytes) -> bytes:
    start, _ = _span(rng, data)
    return data[:start] + rng.choice((rng.choice(_BAD_BYTES), rng.randbytes(rng.randint(1, 16)))) + data[start:]


def _exchange_spans(rng: random.Random, data: bytes) -> bytes:
    (a, b), (c, d) = sorted((_span(rng, data), _span(rng, data)))
    if b > c:
        return data
    return data[:a] + data[c:d] + data[b:c] + data[a:b] + data[d:]


def _put_number(rng: random.Random, data: bytes) -> bytes:
    """Put an integer or a float that is absurd where some number may be."""
    form = rng.choice("BHIQfd")
    value = rng.choice(_FLOATS) if form in "fd" else rng.choice(_INTEGERS) % 2 ** (8 * struct.calcsize(form))
    packed = struct.pack(f"<{form}", value)
    start = rng.randrange(len(data) + 1) // len(packed) * len(packed)
    return data[:start] + packed + data[start + len(packed) :]


def _tokens(data: bytes, pattern: re.Pattern[bytes]) -> list[tuple[int, int]]:
    return [match.span() for match in pattern.finditer(data)]


def _replace_number(rng: random.Random, data: bytes) -> bytes:
    numbers = _tokens(data, _NUMBER)
    if not numbers:
        return data
    # Counts stand early; the many numbers of the motion would hide them.
    start, end = rng.choice(numbers[:40] if rng.random() < 0.5 else numbers)
    return data[:start] + rng.choice(_BAD_NUMBERS) + data[end:]


def _replace_many_numbers(rng: random.Random, data: bytes) -> bytes:
    bad, share = rng.choice(_BAD_NUMBERS), rng.choice((0.02, 0.3, 1.0))
    return _NUMBER.sub(lambda match: bad if rng.random() < share else match.group(), data)


def _swap_tokens(rng: random.Random, data: bytes) -> bytes:
    tokens = _tokens(data, _TOKEN)
    if len(tokens) < 2:
        return data
    (a, b), (c, d) = sorted(rng.sample(tokens, 2))
    return data[:a] + data[c:d] + data[b:c] + data[a:b] + data[d:]


def _change_token(rng: random.Random, data: bytes) -> bytes:
    """Delete a token, double it or put another one of the file in its place."""
    tokens = _tokens(data, _TOKEN)
    if not tokens:
        return data
    start, end = rng.choice(tokens)
    other = slice(*rng.choice(tokens))
    return data[:start] + rng.choice((b"", data[start:end] * 2, data[other], b" " + data[other])) + data[end:]


def _rename_token(rng: random.Random, data: bytes) -> bytes:
    """Change a word everywhere, so that what refers to it still does."""
    tokens = _tokens(data, _TOKEN)
    if not tokens:
        return data
    old = data[slice(*rng.choice(tokens))]
    return data.replace(old, rng.choice((b"", b"x", b"a b", b"\xff", b"A" * 5000, b"..", b"/", "ä".encode())))


def _change_lines(rng: random.Random, data: bytes) -> bytes:
    lines = data.split(b"\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    match rng.randrange(4):
        case 0:
            del lines[i]
        case 1:
            lines[i : i + 1] = [lines[i]] * rng.choice((2, 2, 5, 3000))
        case 2:
            lines[i], lines[j] = lines[j], lines[i]
        case _:
            del lines[min(i, j) : max(i, j)]
    return b"\n".join(lines)


def _nest(rng: random.Random, data: bytes, nests: Sequence[tuple[bytes, bytes, bytes]]) -> bytes:
    """Put levels of nesting into the file, closed again or not."""
    opening, closing, behind = rng.choice(nests)
    places = [match.end() for match in re.finditer(re.escape(behind), data)] or [len(data)]
    start, depth = rng.choice(places), rng.choice(_DEEP)
    depth = min(depth, _MOST_BYTES // 2 // (len(opening) + len(closing)))
    closed = closing * rng.choice((depth, depth, depth, 0, depth // 2))
    return data[:start] + opening * depth + closed + data[start:]


_BINARY: tuple[Mutator, ...] = (
    *(_truncate, _flip_bits, _flip_bits, _overwrite, _delete_span, _repeat_span, _insert_bytes, _exchange_spans),
    *(_put_number, _put_number),
)
_TEXTUAL: tuple[Mutator, ...] = (
    *(_replace_number, _replace_number, _replace_number, _replace_many_numbers, _swap_tokens, _change_token),
    *(_rename_token, _change_lines, _change_lines),
)
