"""Slow twin of the path search: list every path there is and sort.

Every function takes, per sketch fragment, the candidates' distances, and per join a table of booleans that says which
two candidates were consecutive in their take.
"""

import itertools


def zero_joins(choice, consecutive):
    """Give a path's zero-cost joins as (position, left candidate, right candidate)."""
    return frozenset(
        (q, choice[q], choice[q + 1]) for q in range(len(choice) - 1) if consecutive[q][choice[q]][choice[q + 1]]
    )


def list_paths(distances):
    """List every path: one candidate index per sketch fragment."""
    return list(itertools.product(*(range(len(column)) for column in distances)))


def sum_of_distances(choice, distances):
    """Add up the matching distances of a path."""
    return sum(distances[q][k] for q, k in enumerate(choice))


def continuity_cost(choice, distances, lengths, consecutive, gaps, weight):
    """Sum distance / length, and the weighted pose gap at each join that is not consecutive."""
    cost = sum(distances[q][k] / lengths[q] for q, k in enumerate(choice))
    for q in range(len(choice) - 1):
        left, right = choice[q], choice[q + 1]
        if not consecutive[q][left][right]:
            cost += weight * gaps[q][left][right]
    return cost


def rank_consecutive(distances, consecutive, count):
    """Rank as the paper: most zero-cost joins, then least distance; one path per set of joins, then by distance."""

    def score(choice):
        return (-len(zero_joins(choice, consecutive)), sum_of_distances(choice, distances))

    paths = list_paths(distances)
    found = _first_of_each_set(sorted(paths, key=score), consecutive)
    by_distance = sorted(paths, key=lambda choice: sum_of_distances(choice, distances))
    return _fill_up(found, by_distance, count)


def rank_continuity(distances, lengths, consecutive, gaps, weight, count):
    """Rank by the continuity cost; one path per set of zero-cost joins, then the next cheapest."""
    by_cost = sorted(
        list_paths(distances),
        key=lambda choice: continuity_cost(choice, distances, lengths, consecutive, gaps, weight),
    )
    return _fill_up(_first_of_each_set(by_cost, consecutive), by_cost, count)


def _first_of_each_set(ranked, consecutive):
    seen = set()
    found = []
    for choice in ranked:
        joins = zero_joins(choice, consecutive)
        if joins not in seen:
            seen.add(joins)
            found.append(choice)
    return found


def _fill_up(found, ranked, count):
    rest = [choice for choice in ranked if choice not in found]
    return (found + rest)[:count]
