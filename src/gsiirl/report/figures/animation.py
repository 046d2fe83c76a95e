"""A moving figure as a GIF, with its last frame as a still picture."""

import io
from collections.abc import Callable

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

DOTS_PER_INCH = 100
COLOURS = 128
STEP_MILLISECONDS, LAST_MILLISECONDS = 160, 1800


def animate(draw: Callable[[int], Figure], frames: int) -> dict[str, bytes]:
    """The figures draw(0), ..., draw(frames - 1), all of one size, in an endless loop, as `gif`; the last as `png`.

    The same figures give the same bytes.
    """
    first, *others = images = _with_one_palette(np.stack([_pixels(draw(frame)) for frame in range(frames)]))
    durations = [STEP_MILLISECONDS] * (frames - 1) + [LAST_MILLISECONDS]
    still, stream = io.BytesIO(), io.BytesIO()
    images[-1].save(still, format="PNG")
    first.save(stream, format="GIF", save_all=True, append_images=others, duration=durations, loop=0)
    return {"png": still.getvalue(), "gif": stream.getvalue()}


def _pixels(figure: Figure) -> np.ndarray:
    """Colours [height, width] as red * 2^16 + green * 2^8 + blue."""
    figure.set_dpi(DOTS_PER_INCH)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    red, green, blue, _ = np.moveaxis(np.asarray(canvas.buffer_rgba()).astype(np.uint32), -1, 0)
    return red << 16 | green << 8 | blue


def _with_one_palette(frames: np.ndarray) -> list[Image.Image]:
    """Images of frames [frames, height, width], each pixel in the nearest of the most frequent colours.

    Pillow's own reduction mixes colours, and white would not stay white.
    """
    codes, place, counts = np.unique(frames, return_inverse=True, return_counts=True)
    colours = np.stack([codes >> 16, codes >> 8 & 255, codes & 255], axis=1).astype(float)
    palette = colours[np.lexsort((codes, -counts))[:COLOURS]]
    nearest = np.linalg.norm(colours[:, None] - palette[None], axis=-1).argmin(axis=1).astype(np.uint8)
    images = []
    for frame in nearest[place.reshape(frames.shape)]:
        image = Image.frombytes("P", frame.shape[::-1], frame.tobytes())
        image.putpalette(palette.astype(np.uint8).tobytes())
        images.append(image)
    return images
