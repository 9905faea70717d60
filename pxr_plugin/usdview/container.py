"""What usdview loads: the commands and their menu.

usdview finds this module by plugInfo.json and makes one container. Commands are imported when the first is used, so
that usdview starts no slower, and Qt only inside them.
"""

from typing import Any

from pxr import Tf
from pxr.Usdviewq.plugin import PluginContainer

__all__ = ["MotionTextureContainer"]

_MENU = "Motion Texture"
_NAME = "MotionTextureContainer"

# Function in the commands module, name in the menu, shortcut, what it does; None is a line between.
_COMMANDS: tuple[tuple[str, str, str | None, str] | None, ...] = (
    ("next_path", "Next Path", "Ctrl+Alt+N", "Show the next path of the selected characters"),
    ("previous_path", "Previous Path", "Ctrl+Alt+P", "Show the path before of the selected characters"),
    ("show_original", "Original", "Ctrl+Alt+O", "Show what the animator made of the selected characters"),
    None,
    ("list_paths", "Paths...", None, "List the paths of the selected characters with rank, distance and joins"),
    ("show_fragments", "Show Fragments...", None, "List which times come from which take"),
    None,
    ("process_animation", "Process This Animation...", None, "Make paths for the selected characters' animations"),
    ("edit_contact", "Edit Contact...", None, "Move a contact in time and space"),
    None,
    ("accept_path", "Accept Path...", None, "Write what is shown of the selected characters into a layer"),
)


class MotionTextureContainer(PluginContainer):
    """Registers the commands with usdview, and puts them into a menu of their own."""

    def registerPlugins(self, plugRegistry: Any, usdviewApi: Any) -> None:  # noqa: ARG002, N802, N803
        """Register every command; called by usdview.

        Parameters
        ----------
        plugRegistry
            That of usdview, for commands.
        usdviewApi
            Given again to each command that runs.
        """
        commands = self.deferredImport("mtex_usd.usdview.commands")  # type: ignore[no-untyped-call]
        self._plugins = {
            entry[0]: plugRegistry.registerCommandPlugin(
                f"{_NAME}.{entry[0]}", entry[1], getattr(commands, entry[0]), description=entry[3]
            )
            for entry in _COMMANDS
            if entry
        }

    def configureView(self, plugRegistry: Any, plugUIBuilder: Any) -> None:  # noqa: ARG002, N802, N803
        """Put the commands into the menu; called by usdview.

        Parameters
        ----------
        plugRegistry
            That of usdview, for commands.
        plugUIBuilder
            That of usdview, for menus.
        """
        menu = plugUIBuilder.findOrCreateMenu(_MENU)
        for entry in _COMMANDS:
            if entry is None:
                menu.addSeparator()
            else:
                menu.addItem(self._plugins[entry[0]], shortcut=entry[2])


Tf.Type.Define(MotionTextureContainer)
