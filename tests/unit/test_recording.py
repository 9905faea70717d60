"""What a recording may hold, and how errors of files travel."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mtex_usd.formats.recording import FormatError, NoMotionError, Recording

RECORDING = Recording(
    source=Path("walk.bvh"),
    names=("A", "B"),
    parents=(-1, 0),
    offsets=np.zeros((2, 3)),
    rate=30.0,
    rotations=np.tile([1.0, 0.0, 0.0, 0.0], (4, 2, 1)),
    translations=np.zeros((4, 2, 3)),
)


def spoil(values: np.ndarray, bad: float) -> np.ndarray:
    values = values.copy()
    values.flat[-1] = bad
    return values


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 3.5e38, -1e300])
@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("rotations", RECORDING.rotations),
        ("translations", RECORDING.translations),
        ("offsets", RECORDING.offsets),
        ("scales", np.ones((4, 2, 3))),
        ("rest", np.tile(np.eye(4), (2, 1, 1))),
        ("bind", np.tile(np.eye(4), (2, 1, 1))),
        ("placement", np.eye(4)),
    ],
)
def test_numbers_that_no_take_can_hold_are_refused(name: str, values: np.ndarray, bad: float) -> None:
    replace(RECORDING, **{name: values})
    with pytest.raises(FormatError, match=rf"walk\.bvh: {name} hold a number that is not finite or larger than"):
        replace(RECORDING, **{name: spoil(values, bad)})


def test_scales_are_kept_in_half_precision() -> None:
    scales = np.ones((4, 2, 3))
    replace(RECORDING, scales=spoil(scales, 65504.0))
    with pytest.raises(FormatError, match=r"Run: scales hold a number that is not finite or larger than 65504"):
        replace(RECORDING, clip="Run", scales=spoil(scales, 65505.0))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"rate": np.nan}, "bad rate of nan frames per second"),
        ({"rate": 0.0}, "bad rate of 0 frames per second"),
        ({"rate": 1e30}, r"bad rate of 1e\+30 frames per second"),
        ({"meters_per_unit": np.inf}, "bad unit of inf metres"),
        ({"meters_per_unit": -1.0}, "bad unit of -1 metres"),
        ({"up_axis": "W"}, "bad up axis 'W'; expected Y or Z"),
    ],
)
def test_rates_units_and_axes_that_are_none_are_refused(change: dict[str, object], reason: str) -> None:
    with pytest.raises(FormatError, match=reason):
        replace(RECORDING, **change)


def test_a_chain_whose_paths_would_fill_the_memory_is_refused() -> None:
    def chain(count: int) -> Recording:
        return replace(
            RECORDING,
            names=("Joint",) * count,
            parents=tuple(range(-1, count - 1)),
            offsets=np.zeros((count, 3)),
            rotations=np.tile([1.0, 0.0, 0.0, 0.0], (1, count, 1)),
            translations=np.zeros((1, count, 3)),
        )

    assert chain(1000).frame_count == 1
    with pytest.raises(FormatError, match="its 5000 joints are nested too deep for any skeleton"):
        chain(5000)


@pytest.mark.parametrize("kind", [FormatError, NoMotionError])
def test_errors_travel_between_processes(kind: type[FormatError]) -> None:
    error = pickle.loads(pickle.dumps(kind(Path("a.bvh"), 3, "bad")))
    assert type(error) is kind
    assert (error.file_path, error.line, error.reason, str(error)) == (Path("a.bvh"), 3, "bad", "a.bvh:3: bad")


def test_reasons_that_quote_the_file_by_the_page_are_cut() -> None:
    error = FormatError(Path("a.usda"), None, f"expected a bracket at '{'(' * 100_000}' in </Model>")
    assert len(str(error)) < 600
    assert str(error).startswith("a.usda: expected a bracket at '((")
    assert str(error).endswith("((' in </Model>")
