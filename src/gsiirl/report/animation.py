"""A figure that moves, as a GIF."""

import base64
import io
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

DOTS_PER_INCH = 100
COLOURS = 128
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
    images = _with_one_palette([_pixels(draw(frame)) for frame in range(frames)])
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


def _pixels(figure: Figure) -> np.ndarray:
    figure.set_dpi(DOTS_PER_INCH)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].astype(np.uint32)


def _with_one_palette(frames: list[np.ndarray]) -> list[Image.Image]:
    """Frames in the colours that fill most of them; any other becomes the nearest of these.

    Pillow's own reduction mixes colours, and white would not stay white.
    """
    packed = [frame[..., 0] << 16 | frame[..., 1] << 8 | frame[..., 2] for frame in frames]
    counts: Counter[int] = Counter()
    for frame in packed:
        counts.update(dict(zip(*(each.tolist() for each in np.unique(frame, return_counts=True)), strict=True)))
    codes = np.array(sorted(counts, key=lambda code: (-counts[code], code)))
    colours = np.stack([codes >> 16, codes >> 8 & 255, codes & 255], axis=1)
    palette = colours[:COLOURS]
    nearest = np.zeros(1 << 24, dtype=np.uint8)
    nearest[codes] = np.linalg.norm(colours[:, None] - palette[None], axis=-1).argmin(axis=1)
    images = []
    for frame in packed:
        height, width = frame.shape
        image = Image.frombytes("P", (width, height), nearest[frame].tobytes())
        image.putpalette(palette.astype(np.uint8).tobytes())
        images.append(image)
    return images
