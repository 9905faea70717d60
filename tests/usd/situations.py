"""Every situation a sketch is found in, by name: 21 base ones, and those that bend time, names or instancing.

``SITUATIONS[name](folder)`` writes the layers of one into a folder and tells what should come of it.
"""

from collections.abc import Callable
from pathlib import Path

from tests.usd import base_situations as base
from tests.usd import more_situations as more
from tests.usd.stage_parts import Situation

__all__ = ["BASE_SITUATIONS", "MORE_SITUATIONS", "SITUATIONS", "Builder", "Situation"]

Builder = Callable[[Path], Situation]

_TWICE: dict[str, Callable[[Path, str], Situation]] = {
    "local": base.build_local,
    "referenced": base.build_referenced,
    "payloaded": base.build_payloaded,
    "instanceable": base.build_instanceable,
    "asset_variants": base.build_asset_variants,
    "local_variants": base.build_local_variants,
    "two_skeletons": base.build_two_skeletons,
    "default_only": base.build_default_only,
}


def _on(builder: Callable[[Path, str], Situation], on: str) -> Builder:
    return lambda folder: builder(folder, on)


BASE_SITUATIONS: dict[str, Builder] = {
    **{f"{name}-{on}": _on(builder, on) for name, builder in _TWICE.items() for on in ("Skeleton", "SkelRoot")},
    "inherited_binding": base.build_inherited_binding,
    "inherited_binding_instanceable": base.build_inherited_binding_instanceable,
    "unbound": base.build_unbound,
    "animation_layer": base.build_animation_layer,
    "value_clips": base.build_value_clips,
}
MORE_SITUATIONS: dict[str, Builder] = {
    "offset_sublayer": more.build_offset_sublayer,
    "scaled_reference": more.build_scaled_reference,
    "other_rates": more.build_other_rates,
    "two_characters": more.build_two_characters,
    "two_instances": more.build_two_instances,
    "two_sketches": more.build_two_sketches,
    "nested_models": more.build_nested_models,
    "nested_instances": more.build_nested_instances,
    "nested_instance_pair": more.build_nested_instance_pair,
    "value_clips_on_model": more.build_value_clips_on_model,
    "value_clips_elsewhere": more.build_value_clips_elsewhere,
    "package": more.build_package,
    "no_model": more.build_no_model,
}
SITUATIONS: dict[str, Builder] = BASE_SITUATIONS | MORE_SITUATIONS
