"""MtexSegmentAPI: the contract of its properties, and reading segments in order of time."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pxr import Sdf, Usd

from mtex_usd.errors import InputError
from mtex_usd.texture.recipe import Segment
from mtex_usd.usd.schema import SEGMENT_API, api_instances, read_recipe
from tests.usd.schema_support import check_presentation, open_sublayer, open_text, property_contract

PREFIX = "mtex:segment:__INSTANCE_NAME__:"
CONTRACT = {
    f"{PREFIX}start": ("timecode", None),
    f"{PREFIX}end": ("timecode", None),
    f"{PREFIX}match": ("token[]", None),
    f"{PREFIX}break": ("token", None),
    f"{PREFIX}matchBand": ("int", None),
    f"{PREFIX}texture": ("token[]", None),
    f"{PREFIX}synthesize": ("token[]", None),
    f"{PREFIX}textureBands": ("int2", None),
    f"{PREFIX}scale": ("bool", None),
}


def segments_text(body: str, *instances: str) -> str:
    names = ", ".join(f'"{SEGMENT_API}:{instance}"' for instance in instances)
    return f'def SkelAnimation "Sketch" (prepend apiSchemas = ["MtexSketchAPI", {names}])\n{{\n{body}\n}}\n'


def span_text(instance: str, start: float, end: float) -> str:
    prefix = f"uniform timecode mtex:segment:{instance}"
    return f"{prefix}:start = {start}\n{prefix}:end = {end}\n"


def read_segments(body: str, *instances: str) -> tuple[Segment, ...]:
    stage = open_text(segments_text(body, *instances))
    return read_recipe(stage.GetPrimAtPath("/Sketch")).segments


def test_properties_are_the_contract() -> None:
    assert property_contract(SEGMENT_API) == CONTRACT


def test_properties_present_themselves() -> None:
    check_presentation(SEGMENT_API)


def test_applies_to_animations_only() -> None:
    stage = Usd.Stage.CreateInMemory()
    assert stage.DefinePrim("/Sketch", "SkelAnimation").CanApplyAPI(SEGMENT_API, "stomp")
    assert not stage.DefinePrim("/Model", "Xform").CanApplyAPI(SEGMENT_API, "stomp")


def test_what_is_not_authored_inherits() -> None:
    assert read_segments(span_text("stomp", 10, 20), "stomp") == (Segment(name="stomp", start=10.0, end=20.0),)


def test_everything_authored() -> None:
    body = span_text("stomp", 10, 20.5) + (
        'token[] mtex:segment:stomp:match = ["LeftLeg.rx"]\n'
        'token mtex:segment:stomp:break = "LeftUpLeg.rx"\n'
        "int mtex:segment:stomp:matchBand = 3\n"
        "token[] mtex:segment:stomp:texture = []\n"
        'token[] mtex:segment:stomp:synthesize = ["*Arm*"]\n'
        "int2 mtex:segment:stomp:textureBands = (2, 4)\n"
        "bool mtex:segment:stomp:scale = true\n"
    )
    expected = Segment(
        name="stomp",
        start=10.0,
        end=20.5,
        match=("LeftLeg.rx",),
        break_channel="LeftUpLeg.rx",
        match_band=3,
        texture=(),
        synthesize=("*Arm*",),
        texture_bands=(2, 4),
        scale=True,
    )
    assert read_segments(body, "stomp") == (expected,)


def test_segments_come_in_order_of_time_and_may_touch() -> None:
    segments = read_segments(span_text("a", 20, 30) + span_text("b", 5, 20) + span_text("c", 40, 50), "a", "b", "c")
    assert [segment.name for segment in segments] == ["b", "a", "c"]


SPANS = st.lists(st.tuples(st.integers(0, 30), st.integers(1, 8)).map(lambda s: (s[0], s[0] + s[1])), max_size=5)


@given(spans=SPANS)
def test_segments_are_refused_where_any_two_share_more_than_an_end(spans: list[tuple[int, int]]) -> None:
    names = [f"s{i}" for i in range(len(spans))]
    body = "".join(span_text(name, *span) for name, span in zip(names, spans, strict=True))
    overlapping = any(max(a[0], b[0]) < min(a[1], b[1]) for a, b in itertools.combinations(spans, 2))
    if overlapping:
        with pytest.raises(InputError, match="overlap"):
            read_segments(body, *names)
    else:
        assert [(s.start, s.end) for s in read_segments(body, *names)] == sorted(spans)


def test_layer_offset_moves_segments() -> None:
    stage = open_sublayer(segments_text(span_text("a", 10, 20), "a"), Sdf.LayerOffset(100.0, 2.0))
    (segment,) = read_recipe(stage.GetPrimAtPath("/Sketch")).segments
    assert (segment.start, segment.end) == (120.0, 140.0)


def test_only_applied_instances_count() -> None:
    assert [s.name for s in read_segments(span_text("a", 1, 2) + span_text("b", 1, 2), "b")] == ["b"]


def test_instances_in_order_of_strength() -> None:
    stage = open_text(segments_text("", "b", "a"))
    assert api_instances(stage.GetPrimAtPath("/Sketch"), SEGMENT_API) == ("b", "a")
    assert api_instances(stage.GetPrimAtPath("/Sketch"), "MtexSketchAPI") == ()


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (span_text("a", 1, 10) + span_text("b", 9, 20), r"segments a and b overlap; .*found 1 to 10 and 9 to 20"),
        (span_text("a", 1, 10) + span_text("b", 1, 10), r"segments a and b overlap"),
        (span_text("a", 1, 10), r"/Sketch: segment b has no start; expected timecode mtex:segment:b:start"),
        ("timecode mtex:segment:a:start = 1", r"segment a has no end; expected timecode mtex:segment:a:end"),
        (span_text("a", 10, 10), r"segment a is empty; expected start before end; found 10 to 10"),
        (span_text("a", 10, 1), r"segment a is empty"),
        ("double mtex:segment:a:start = 1", r"segment:a:start has the wrong type; expected timecode; found double"),
        (span_text("a", 1, 2) + "int mtex:segment:a:matchBand = -1", r"segment:a:matchBand is not allowed"),
        (span_text("a", 1, 2) + "int mtex:segment:a:matchband = 1", r"Did you mean mtex:segment:a:matchBand\?"),
        ("timecode mtex:segment:a:start = inf", r"segment:a:start is not allowed; expected a finite time code"),
    ],
)
def test_bad_segments(body: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_segments(body, "a", "b")
