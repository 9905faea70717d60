"""The mtex schemas as they are read off prims, whether or not USD knows them in this process.

Applied schemas come from composed metadata and values from authored attributes, so a stage reads the same in a process
that never registered the plugin. Defaults are those of the objects that are read. By USD's convention a property counts
only where its schema is applied, so that ``delete apiSchemas`` in a stronger layer switches it off.
"""

from mtex_usd.usd.schema.applied import api_instances, authored, has_api
from mtex_usd.usd.schema.contact import CONTACT_API, CONTACT_MODES, ContactSettings, read_contacts
from mtex_usd.usd.schema.edit import EDIT_API, EDIT_STACK_API, EditSettings, EditStacks, read_edit, read_stacks
from mtex_usd.usd.schema.retarget import RETARGET_API, read_pairs
from mtex_usd.usd.schema.sketch import SEGMENT_API, SKETCH_API, TAKES_PROPERTY, read_recipe
from mtex_usd.usd.schema.take import TAKE_API, TakeSettings, read_take_settings

__all__ = [
    "CONTACT_API",
    "CONTACT_MODES",
    "EDIT_API",
    "EDIT_STACK_API",
    "RETARGET_API",
    "SEGMENT_API",
    "SKETCH_API",
    "TAKES_PROPERTY",
    "TAKE_API",
    "ContactSettings",
    "EditSettings",
    "EditStacks",
    "TakeSettings",
    "api_instances",
    "authored",
    "has_api",
    "read_contacts",
    "read_edit",
    "read_pairs",
    "read_recipe",
    "read_stacks",
    "read_take_settings",
]
