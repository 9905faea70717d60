"""Slow twin of the matching: stretch every take fragment, one frame of one channel at a time, and compare."""


def stretch(curve, first, last, frame_count):
    """Resample frames first to last of one curve linearly to a number of frames."""
    out = []
    for i in range(frame_count):
        position = first + (last - first) * i / (frame_count - 1)
        left = min(int(position), last - 1)
        part = position - left
        out.append(curve[left] * (1.0 - part) + curve[left + 1] * part)
    return out


def distance(sketch, fragment, pool, candidate):
    """Sum the squared differences over channels; both clips are lists of curves (values and slopes alike)."""
    first, last = fragment
    total = 0.0
    for own, taken in zip(sketch, pool, strict=True):
        stretched = stretch(taken, candidate[0], candidate[1], last - first + 1)
        for i, value in enumerate(stretched):
            total += (own[first + i] - value) ** 2
    return total


def match(sketch, fragment, pool, candidates, count, max_stretch):
    """Give the closest candidates as (distance, index), closest first, and whether the stretch limit was lifted."""
    length = fragment[1] - fragment[0]
    allowed = [i for i, (first, last) in enumerate(candidates) if last - first <= max_stretch * length]
    lifted = not allowed
    if lifted:
        allowed = list(range(len(candidates)))
    ranked = sorted((distance(sketch, fragment, pool, candidates[i]), i) for i in allowed)
    return ranked[:count], lifted


def derivative(curve):
    """Central differences per frame, one-sided at the ends."""
    last = len(curve) - 1
    out = []
    for frame in range(last + 1):
        before, after = max(frame - 1, 0), min(frame + 1, last)
        out.append((curve[after] - curve[before]) / (after - before))
    return out
