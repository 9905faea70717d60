"""The spacetime solve against its slow twin, on windows small enough for it."""

import numpy as np
import pytest

from mtex_usd.constraints.spacetime import DistanceBetween, PlaneAbove, Point, PointAt, PointStill, solve_spacetime
from tests.oracle import spacetime as twin
from tests.spacetime_support import follow
from tests.synthetic import LEFT_FOREARM, LEFT_KNEE, RIGHT_FOREARM, walk

FRAMES = 14
CM = 0.01
EXACT = 1e-7  # metres: within a tolerance there is a cheaper motion, which the twin does not look for
HAND, FOOT = Point(LEFT_FOREARM, (25.0, 0.0, 0.0)), Point(LEFT_KNEE, (0.0, -45.0, 0.0))
OTHER = Point(RIGHT_FOREARM, (-25.0, 0.0, 0.0))


def cases(clip):
    """Our constraints and the twin's."""
    hand, foot = follow(clip, HAND), follow(clip, FOOT)
    held = np.arange(4, 10)
    floor = float(np.sort(foot[:, 1])[5])
    apart = float(np.linalg.norm(hand[7] - follow(clip, OTHER)[7]) - 15.0)
    joint = {point: clip.joints.index(point.joint) for point in (HAND, FOOT, OTHER)}

    def offset(point):
        return CM * np.array(point.offset)

    return {
        "reach": (
            [PointAt("hand", HAND, [7], hand[7] + 6.0, tolerance=EXACT)],
            [("at", joint[HAND], offset(HAND), [7], CM * (hand[7] + 6.0))],
        ),
        "plant": ([PointStill("foot", FOOT, held, tolerance=EXACT)], [("still", joint[FOOT], offset(FOOT), held)]),
        "floor": (
            [PlaneAbove("floor", FOOT, np.arange(FRAMES), floor, tolerance=EXACT)],
            [("above", joint[FOOT], offset(FOOT), np.arange(FRAMES), np.array([0.0, 1.0, 0.0]), CM * floor)],
        ),
        "carry": (
            [DistanceBetween("box", HAND, OTHER, [6, 7, 8], apart, tolerance=EXACT)],
            [("apart", joint[HAND], offset(HAND), [6, 7, 8], joint[OTHER], offset(OTHER), CM * apart)],
        ),
    }


def run_twin(clip, solution, constraints):
    """Solve on the knots that we ended on, with the weights we state: a reach of translation is a radian."""
    (character,) = solution.memory.cast.characters
    motion = twin.Motion(
        parents=clip.parents.tolist(),
        rotations=clip.rotations,
        translations=CM * clip.translations,
        turning=list(character.turning),
        root=0,
    )
    lengths = np.linalg.norm(CM * clip.translations, axis=2).mean(axis=0)
    reach = max(sum(lengths[clip.skeleton.chain(joint)[1:]]) for joint in range(len(clip.joints)))
    weights = np.array([1.0] * (motion.channels - 3) + [1.0 / reach**2] * 3)
    extended = solution.memory.knots.extended
    return motion, twin.solve(motion, constraints, extended, weights, smoothness=30.0, cycles_per_frame=6.0 / 24.0)


@pytest.mark.parametrize("name", ["reach", "plant", "floor", "carry"])
def test_the_optimum_is_the_twins(name):
    clip = walk(FRAMES)
    ours, theirs = cases(clip)[name]
    solution = solve_spacetime(clip, ours)
    motion, (coefficients, cost, left) = run_twin(clip, solution, theirs)
    inequality = name == "floor"
    assert (left.min() > -1e-6) if inequality else (np.abs(left).max() < 1e-6)
    (change,) = solution.displacements
    basis = solution.memory.knots.matrix
    expected = basis @ coefficients
    found = np.concatenate([change.rotations[:, motion.turning].reshape(FRAMES, -1), CM * change.translation], axis=1)
    largest = np.abs(expected).max()
    assert largest > 0.01
    np.testing.assert_allclose(found, expected, atol=1e-3 * largest)
    assert cost > 0.0
