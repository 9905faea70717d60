"""Slow twin of the contact detection: every curve and every decision frame by frame."""

import math

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

SMOOTHING_S = 0.025
LEAVE = 1.5
OWN_LEVEL_M = 0.04
ONE_PLANT_M = 0.05


def track_point(parents, rotations, translations, joint, offset):
    """Follow a point of one joint, [F, 3]; rotations [F, J, 4] real first, translations [F, J, 3]."""
    point = np.tile(np.asarray(offset, dtype=float), (len(rotations), 1))
    while joint >= 0:
        point = Rotation.from_quat(rotations[:, joint], scalar_first=True).apply(point) + translations[:, joint]
        joint = parents[joint]
    return point


def smooth_curves(points, rate, up):
    """Heights, speeds and steps per frame of one point [F, 3] on a grid of at least 120 steps per second."""
    steps = max(math.ceil(120.0 / rate - 1e-6), 1)
    if steps > 1:
        spline = CubicSpline(range(len(points)), points)
        points = np.array([spline(i / steps) for i in range((len(points) - 1) * steps + 1)])
    heights, speeds = [], []
    for i in range(len(points)):
        place, velocity = _weigh(points, i, rate * steps)
        heights.append(float(place @ up))
        speeds.append(math.sqrt(velocity @ velocity))
    return heights, speeds, steps


def _weigh(points, middle, rate):
    width = SMOOTHING_S * rate
    reach = math.ceil(4.0 * width)
    total, place, slope, normal = 0.0, np.zeros(3), np.zeros(3), 0.0
    for k in range(-reach, reach + 1):
        weight = math.exp(-0.5 * (k / width) ** 2)
        value = _reflected(points, middle + k)
        total += weight
        place += weight * value
        slope += weight * k * value
        normal += weight * k * k
    return place / total, slope / normal * rate


def _reflected(points, index):
    if index < 0:
        return 2.0 * points[0] - points[-index]
    if index >= len(points):
        return 2.0 * points[-1] - points[2 * len(points) - 2 - index]
    return points[index]


def own_levels(curves, speed, scale):
    """Level of each point from its curves, kept near the median of those that stand near the lowest."""
    levels = []
    for heights, speeds, _ in curves:
        slow = [h for h, v in zip(heights, speeds, strict=True) if v < speed]
        levels.append(float(np.quantile(slow, 0.1)) if slow else float(np.quantile(heights, 0.02)))
    low = [level for level in levels if level <= min(levels) + 2.0 * OWN_LEVEL_M * scale]
    ground = float(np.median(low))
    slack = OWN_LEVEL_M * scale
    return [min(max(level, ground - slack), ground + slack) for level in levels]


def find_runs(heights, speeds, steps, level, height, speed):
    """Frames (first, last) where a point is planted, by one pass that remembers where the current run began."""
    runs, begin, sure = [], None, False
    for i in range(len(heights) + 1):
        inside = i < len(heights) and heights[i] - level <= LEAVE * height and speeds[i] <= LEAVE * speed
        if not inside:
            if begin is not None and sure:
                runs.append((math.ceil(begin / steps), (i - 1) // steps))
            begin, sure = None, False
            continue
        begin = i if begin is None else begin
        sure = sure or (heights[i] - level <= height and speeds[i] <= speed)
    return [run for run in runs if run[0] <= run[1]]


def merge_runs(runs, points, shortest, scale):
    """Join runs a moment apart at one place, then drop short ones; `shortest` in frames."""
    merged = []
    for first, last in runs:
        if merged and first - merged[-1][1] <= shortest:
            before = plant(points[merged[-1][0] : merged[-1][1] + 1])
            if math.dist(before, plant(points[first : last + 1])) <= ONE_PLANT_M * scale:
                merged[-1] = (merged[-1][0], last)
                continue
        merged.append((first, last))
    return [run for run in merged if run[1] - run[0] + 1 >= shortest]


def plant(points):
    """Mean place by eight rounds of Cauchy weights."""
    mean = sum(points) / len(points)
    for _ in range(8):
        away = [math.dist(point, mean) for point in points]
        typical = float(np.median(away))
        if typical <= 1e-9 * max(away):
            break
        weights = [1.0 / (typical**2 + d**2) for d in away]
        mean = sum(w * point for w, point in zip(weights, points, strict=True)) / sum(weights)
    return mean


def detect(tracks, rate, up, *, scale, height_m=0.06, speed_m_s=0.35, shortest_s=0.1):
    """Contacts of each track [F, 3]: per track a list of (first, last, point)."""
    curves = [smooth_curves(points, rate, up) for points in tracks]
    levels = own_levels(curves, speed_m_s * scale, scale)
    found = []
    for points, (heights, speeds, steps), level in zip(tracks, curves, levels, strict=True):
        runs = find_runs(heights, speeds, steps, level, height_m * scale, speed_m_s * scale)
        merged = merge_runs(runs, points, shortest_s * rate, scale)
        found.append([(first, last, plant(points[first : last + 1])) for first, last in merged])
    return found
