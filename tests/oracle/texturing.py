"""Slow twins of the two laws of the method: texture and synthesis, for one curve.

Texture: y = x - sum of B_k(x) + sum of B_k(m). Synthesis: the joined path m without its highest bands.
"""

from tests.oracle.pyramid import decompose


def texture(sketch, joined, first_band, last_band):
    """Replace the sketch's bands first to last by those of the joined path."""
    own, _ = decompose(sketch)
    taken, _ = decompose(joined)
    out = [float(value) for value in sketch]
    for number in range(first_band, last_band + 1):
        if number <= len(own):
            out = [y - a + b for y, a, b in zip(out, own[number - 1], taken[number - 1], strict=True)]
    return out


def synthesize(joined, highest_band):
    """Leave out every band above the highest one kept."""
    bands, _ = decompose(joined)
    out = [float(value) for value in joined]
    for band in bands[: highest_band - 1]:
        out = [y - b for y, b in zip(out, band, strict=True)]
    return out
