"""A figure that moves, as a GIF."""

import base64
import io
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

DOTS_PER_INCH = 100
COLOURS = 64
STEP_MILLISECONDS, LAST_MILLISECONDS = 160, 1800


@dataclass(frozen=True)
class Animation:
    """A figure that moves, as the content of one file."""

    kind: ClassVar = "animation"
    gif: bytes

    @property
    def files(self) -> dict[str, bytes]:
        """Contents by the ending of the file's name."""
        return {"gif": self.gif}

    @property
    def address(self) -> str:
        """The animation itself as an address, so that a page needs no other file."""
        return "data:image/gif;base64," + base64.b64encode(self.gif).decode()


def animate(draw: Callable[[int], Figure], frames: int) -> Animation:
    """The figures draw(0), ..., draw(frames - 1) one after the other, for ever; the same give the same bytes."""
    images = [_image(draw(frame)) for frame in range(frames)]
    # The last frame shows everything that the others do; one palette keeps what does not move the same.
    palette = images[-1].quantize(COLOURS)
    images = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    stream = io.BytesIO()
    images[0].save(
        stream,
        format="GIF",
        save_all=True,
        append_images=images[1:],
        duration=[STEP_MILLISECONDS] * (frames - 1) + [LAST_MILLISECONDS],
        loop=0,
    )
    return Animation(stream.getvalue())


def _image(figure: Figure) -> Image.Image:
    figure.set_dpi(DOTS_PER_INCH)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3])
