"""Slow twin of cutting: break where the first derivative changes sign, plateaus keeping the sign before them."""


def find_turns(curve):
    """Give the frames, ends not included, at which the derivative changes sign."""
    turns = []
    sign = 0
    for frame in range(len(curve) - 1):
        rise = curve[frame + 1] - curve[frame]
        here = (rise > 0) - (rise < 0)
        if here and sign and here != sign:
            turns.append(frame)
        sign = here or sign
    return turns


def cut(curve):
    """Give the fragments as pairs of first and last frame; both ends of the curve are breaks."""
    breaks = [0, *find_turns(curve), len(curve) - 1]
    return [(breaks[i], breaks[i + 1]) for i in range(len(breaks) - 1)]
