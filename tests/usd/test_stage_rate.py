"""How fast a stage plays."""

import pytest
from pxr import Usd

from mtex_usd.errors import StageError
from mtex_usd.usd.stage_rate import stage_rate
from tests.usd.animation_support import new_layer, stage_of


class TestStageRate:
    @pytest.mark.parametrize(
        ("metadata", "rate", "time_codes_per_frame"),
        [
            ({}, 24.0, 1.0),
            ({"timeCodesPerSecond": 120.0}, 120.0, 1.0),  # USD reports framesPerSecond 24 here
            ({"timeCodesPerSecond": 120.0, "framesPerSecond": 24.0}, 24.0, 5.0),
            ({"framesPerSecond": 30.0}, 30.0, 1.0),
            ({"timeCodesPerSecond": 1.0, "framesPerSecond": 25.0}, 25.0, 0.04),
            ({"timeCodesPerSecond": 24.0, "framesPerSecond": 23.976}, 23.976, 24.0 / 23.976),
        ],
    )
    def test_frames_per_second_count_where_authored(self, metadata, rate, time_codes_per_frame):
        found = stage_rate(stage_of(new_layer(**metadata)))
        assert found.rate == rate
        assert found.time_codes_per_frame == pytest.approx(time_codes_per_frame, rel=1e-15)

    def test_the_session_layer_wins(self):
        session = new_layer(framesPerSecond=48.0, timeCodesPerSecond=96.0)
        stage = Usd.Stage.Open(new_layer(framesPerSecond=24.0, timeCodesPerSecond=24.0), session)
        assert stage_rate(stage).rate == 48.0
        assert stage_rate(stage).time_codes_per_frame == 2.0

    def test_sublayers_do_not_count(self):
        root, sublayer = new_layer(timeCodesPerSecond=24.0), new_layer(framesPerSecond=60.0)
        root.subLayerPaths.append(sublayer.identifier)
        assert stage_rate(stage_of(root)).rate == 24.0

    def test_refuses_a_stage_that_stands_still(self):
        with pytest.raises(StageError, match=r"expected framesPerSecond and timeCodesPerSecond above 0; found 0 and 0"):
            stage_rate(stage_of(new_layer(framesPerSecond=0.0)))
