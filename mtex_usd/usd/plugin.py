"""Registration of the mtex schemas in this process.

USD builds its schema registry with the first stage and never again, so registering has to come before. Where it came
too late everything here still works, since recipes are read from authored metadata and attributes; what is missing then
are fallbacks, documentation and ``Prim.ApplyAPI`` for our schemas.
"""

from dataclasses import dataclass

from pxr import Plug, Usd

from mtex_usd.plugin_path import plugin_path

__all__ = ["Registration", "register_plugin", "registration_status"]


@dataclass(frozen=True, kw_only=True)
class Registration:
    """Whether USD knows the mtex schemas.

    Parameters
    ----------
    registered
        True where stages of this process have MtexSketchAPI and the others.
    message
        Empty where they have, else what happened and what to do.
    """

    registered: bool
    message: str


def register_plugin() -> None:
    """Tell USD where the mtex schemas are; importing :mod:`mtex_usd.usd` has done so already.

    Where the environment or another copy registered a plugin of that name first, that one stays.

    Raises
    ------
    InputError
        Where the installation lacks the plugin.
    """
    if not Plug.Registry().GetPluginWithName("mtex"):
        Plug.Registry().RegisterPlugins(str(plugin_path()))


def registration_status() -> Registration:
    """Ask USD's schema registry whether it knows the mtex schemas.

    Returns
    -------
    Registration
        With one message for the user where it does not. This is no error: recipes are read either way.

    Notes
    -----
    Asking builds the schema registry where no stage has been opened yet; later registrations of other plugins are then
    too late.
    """
    if Usd.SchemaRegistry().FindAppliedAPIPrimDefinition("MtexSketchAPI"):
        return Registration(registered=True, message="")
    return Registration(
        registered=False,
        message=(
            "the mtex schemas were registered after USD built its schema registry, so this process does not know "
            "MtexSketchAPI; recipes are read all the same. Import mtex_usd before opening the first stage, or set "
            f"PXR_PLUGINPATH_NAME={plugin_path()}"
        ),
    )
