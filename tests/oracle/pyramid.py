"""Slow twin of the pyramid, one frame of one curve at a time."""


def _at(curve, frame):
    """Give a frame's value; beyond the ends the curve continues by point reflection."""
    last = len(curve) - 1
    if frame < 0:
        return 2.0 * curve[0] - curve[-frame]
    if frame > last:
        return 2.0 * curve[last] - curve[2 * last - frame]
    return curve[frame]


def count_bands(frame_count):
    """Count the bands: band k is made only if 2 * 2^(k-1) <= F - 1."""
    count = 0
    while 2 * 2**count <= frame_count - 1:
        count += 1
    return count


def smooth(curve, step):
    """Smooth with [1 4 6 4 1] / 16 spread by a step."""
    return [
        (
            _at(curve, frame - 2 * step)
            + 4.0 * _at(curve, frame - step)
            + 6.0 * _at(curve, frame)
            + 4.0 * _at(curve, frame + step)
            + _at(curve, frame + 2 * step)
        )
        / 16.0
        for frame in range(len(curve))
    ]


def decompose(curve):
    """Split a curve into its bands, highest frequency first, and the residual."""
    bands = []
    level = [float(value) for value in curve]
    for number in range(count_bands(len(level))):
        smoother = smooth(level, 2**number)
        bands.append([a - b for a, b in zip(level, smoother, strict=True)])
        level = smoother
    return bands, level
