"""Drawing rows of strobed stick figures with Pillow, which is imported only where a picture is asked for."""

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from mtex_usd.motion.anatomy import find_anatomy
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.review.body import find_bones, find_front, find_sides

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw

__all__ = ["SHEET_MARK", "SheetBlock", "SheetRow", "draw_sheet"]

FloatArray = npt.NDArray[np.float64]
_Colour = tuple[int, int, int]

SHEET_MARK = "usdmtex review"

_INK, _FAINT, _FLOOR, _PAPER = "#1b1f24", "#5a636e", "#d9dde2", "#ffffff"
_WIDTH, _NARROWEST, _MARGIN, _LABEL = 1600, 900, 24, 190  # pixels
_TITLE, _HEAD, _FOOT = 56, 34, 24
_FIGURE = 160  # pixels a figure is tall at most
_BONE, _SKULL = 2.8, 8.0
_ABOVE, _BELOW = 0.12, 0.1  # of the figures' height, free over and under them
_FINE = 3  # drawn this much larger and reduced, for smooth lines
_LEAST_STEP = 0.3  # heights from one figure to the next, below which they are put side by side
_SPREAD = 0.75


@dataclass(frozen=True, eq=False, kw_only=True)
class SheetRow:
    """One row of figures.

    Parameters
    ----------
    name
        What stands before the row.
    caption
        Lines below the name.
    colour
        Of the figures, ``#rrggbb``; limbs on the left are lighter, on the right darker.
    positions
        Joint positions of each figure, any space with the skeleton's up, shape [N, J, 3].
    """

    name: str
    caption: tuple[str, ...]
    colour: str
    positions: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class SheetBlock:
    """The rows of one character.

    Parameters
    ----------
    heading
        What stands above them.
    skeleton
        Whose joints the positions are.
    time_codes
        Of the figures, shape [N].
    rows
        From the top.
    """

    heading: str
    skeleton: Skeleton
    time_codes: FloatArray
    rows: tuple[SheetRow, ...]


def draw_sheet(blocks: Sequence[SheetBlock], *, title: str, subtitle: str = "", in_place: bool | None = None) -> bytes:
    """Draw rows of strobed figures.

    Parameters
    ----------
    blocks
        From the top.
    title, subtitle
        What stands above all.
    in_place
        Put figures side by side, each seen from its own right side, where True; where they stand, from the right side
        of the first, where False; where None, where they stand if they go far enough not to cover each other.

    Returns
    -------
    bytes
        A PNG file; equal rows give equal bytes.
    """
    from PIL import Image, ImageDraw  # noqa: PLC0415 - slow, and of use here only

    layouts = [_Layout(block, *_place(block, in_place=in_place)) for block in blocks]
    width = max(_NARROWEST, *(layout.width for layout in layouts))
    height = _TITLE + sum(layout.height for layout in layouts) + _MARGIN
    image = Image.new("RGB", (width * _FINE, height * _FINE), _PAPER)
    sheet = _Sheet(ImageDraw.Draw(image), width)
    sheet.write(_MARGIN, 14, title, size=19)
    sheet.write(_MARGIN, 38, subtitle, size=12, colour=_FAINT)
    top = _TITLE
    for layout in layouts:
        layout.draw(sheet, top)
        top += layout.height
    return _to_png(image.resize((width, height), Image.Resampling.LANCZOS))


def _to_png(image: "Image") -> bytes:
    from PIL.PngImagePlugin import PngInfo  # noqa: PLC0415

    mark = PngInfo()
    mark.add_text("Software", SHEET_MARK)
    file = io.BytesIO()
    image.save(file, "PNG", pnginfo=mark, optimize=True)
    return file.getvalue()


@dataclass(frozen=True)
class _Sheet:
    """Drawing in pixels of the finished picture."""

    pen: "ImageDraw"
    width: int

    def write(self, x: float, y: float, text: str, *, size: int, colour: str = _INK, anchor: str = "la") -> None:
        from PIL import ImageFont  # noqa: PLC0415

        font = ImageFont.load_default(size * _FINE)
        self.pen.text((x * _FINE, y * _FINE), text, fill=colour, font=font, anchor=anchor)

    def line(self, a: FloatArray, b: FloatArray, colour: str | _Colour, width: float) -> None:
        ends = [(float(x) * _FINE, float(y) * _FINE) for x, y in (a, b)]
        self.pen.line(ends, fill=colour, width=round(width * _FINE))
        for end in (a, b):
            self.disc(end, colour, width / 2.0)

    def disc(self, middle: FloatArray, colour: str | _Colour, radius: float) -> None:
        x, y, reach = float(middle[0]) * _FINE, float(middle[1]) * _FINE, radius * _FINE
        self.pen.ellipse((x - reach, y - reach, x + reach, y + reach), fill=colour)


@dataclass(frozen=True, eq=False)
class _Layout:
    """A block with the places of its figures' joints in heights of the body, shape [R, N, J, 2]."""

    block: SheetBlock
    places: FloatArray
    bones: tuple[tuple[int, int], ...]

    @property
    def scale(self) -> float:
        """Pixels per height of the body."""
        across, up = (max(float(np.ptp(self.places[..., axis])), 1e-9) for axis in (0, 1))
        return min((_WIDTH - _LABEL - _MARGIN) / across, _FIGURE / up)

    @property
    def row_height(self) -> int:
        return round(max(float(np.ptp(self.places[..., 1])) * self.scale, 60.0) * (1.0 + _ABOVE + _BELOW))

    @property
    def width(self) -> int:
        return round(_LABEL + float(np.ptp(self.places[..., 0])) * self.scale + _MARGIN)

    @property
    def height(self) -> int:
        return _HEAD + len(self.block.rows) * self.row_height + _FOOT

    def draw(self, sheet: _Sheet, top: float) -> None:
        sheet.write(_MARGIN, top + 12, self.block.heading, size=13)
        for number, row in enumerate(self.block.rows):
            floor = top + _HEAD + number * self.row_height + self.row_height * (1.0 - _BELOW)
            self._draw_label(sheet, row, floor)
            self._draw_figures(sheet, row.colour, self._to_pixels(self.places[number], floor))
        self._draw_times(sheet, top + self.height - _FOOT + 4)

    def _to_pixels(self, places: FloatArray, floor: float) -> FloatArray:
        left, low = self.places[..., 0].min(), self.places[..., 1].min()
        x, y = (places[..., 0] - left) * self.scale, (places[..., 1] - low) * self.scale
        return np.stack([_LABEL + x, floor - y], axis=-1)

    def _draw_label(self, sheet: _Sheet, row: SheetRow, floor: float) -> None:
        sheet.line(np.array([_LABEL - 10, floor]), np.array([sheet.width - _MARGIN, floor]), _FLOOR, 1.0)
        top = floor - 0.72 * self.row_height
        sheet.line(np.array([_MARGIN + 2, top + 2]), np.array([_MARGIN + 2, top + 68]), row.colour, 4.0)
        sheet.write(_MARGIN + 12, top, row.name, size=15)
        for line, text in enumerate(row.caption):
            sheet.write(_MARGIN + 12, top + 22 + 16 * line, text, size=12, colour=_FAINT)

    def _draw_figures(self, sheet: _Sheet, colour: str, figures: FloatArray) -> None:
        shades, sides = _shade_sides(colour), find_sides(self.block.skeleton)
        anatomy = find_anatomy(self.block.skeleton)
        head = anatomy.parts.get("head") if anatomy is not None else None
        # Seen from the right, which is therefore nearest.
        order = sorted(self.bones, key=lambda bone: ("left", "middle", "right").index(sides[bone[1]]))
        for figure in figures:
            if head is not None:
                sheet.disc(figure[head], colour, _SKULL * self.scale / _FIGURE)
            for parent, joint in order:
                sheet.line(figure[parent], figure[joint], shades[sides[joint]], _BONE)

    def _draw_times(self, sheet: _Sheet, top: float) -> None:
        for time_code, figure in zip(self.block.time_codes, self._to_pixels(self.places[0], top), strict=True):
            sheet.write(float(figure[:, 0].mean()), top, f"{time_code:g}", size=11, colour=_FAINT, anchor="ma")


def _shade_sides(colour: str) -> dict[str, _Colour]:
    red, green, blue = (int(colour[at : at + 2], 16) for at in (1, 3, 5))
    plain = (red, green, blue)
    return {"left": _mix(plain, 255, 0.42), "middle": plain, "right": _mix(plain, 0, 0.38)}


def _mix(colour: _Colour, other: int, share: float) -> _Colour:
    red, green, blue = (round(value + (other - value) * share) for value in colour)
    return red, green, blue


def _place(block: SheetBlock, *, in_place: bool | None) -> tuple[FloatArray, tuple[tuple[int, int], ...]]:
    """Give where the joints go, and the bones; what is not drawn goes where something is, and needs no room."""
    positions, skeleton = np.stack([row.positions for row in block.rows]), block.skeleton
    bones = find_bones(skeleton, positions[0, 0])
    used = sorted({joint for bone in bones for joint in bone}) or list(range(len(skeleton.joints)))
    height = float(np.ptp(positions[0, 0, used] @ skeleton.up)) or 1.0
    views, shifts = _find_views(positions[0] / height, used, skeleton, in_place=in_place)
    x = np.einsum("rnji,ni->rnj", positions / height, views) + shifts[:, None]
    drawn = np.stack([x, positions @ skeleton.up / height], axis=-1)
    places = np.repeat(drawn[:, :, used[:1]], drawn.shape[2], axis=2)
    places[:, :, used] = drawn[:, :, used]
    return places, bones


def _find_views(
    poses: FloatArray, used: Sequence[int], skeleton: Skeleton, *, in_place: bool | None
) -> tuple[FloatArray, FloatArray]:
    """Give the level direction that is drawn to the right and the shift along it of each figure, [N, 3] and [N]."""
    count, middles = len(poses), poses[:, list(used)].mean(axis=1)
    views = np.array([find_front(skeleton, pose) for pose in poses])
    if in_place or (in_place is None and not _goes_far(middles, views[0])):
        return views, _SPREAD * np.arange(count) - np.einsum("ni,ni->n", middles, views)
    return np.repeat(views[:1], count, axis=0), np.zeros(count)


def _goes_far(middles: FloatArray, view: FloatArray) -> bool:
    """Whether figures go on far enough, and always the same way, not to cover each other where they stand."""
    steps = np.diff(middles @ view)
    return bool(len(steps) and (steps > 0.0).all() and (steps > _LEAST_STEP).mean() > 0.7)
