"""Colours as they are seen: contrast, differences, and vision without one kind of cones.

Matrices, on linear RGB, of Machado, Oliveira and Fernandes, "A physiologically-based model for
simulation of color vision deficiency", IEEE Trans. Vis. Comput. Graphics 15, 1291 (2009), at
severity 1; contrast is that of WCAG 2.2, differences are Euclidean in CIELAB (D65).
"""

import numpy as np
from matplotlib.colors import to_rgb

VISIONS = {
    "normal": np.eye(3),
    "protanopia": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "deuteranopia": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
    "tritanopia": np.array(
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ]
    ),
}
_XYZ = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)
_WHITE = _XYZ.sum(axis=1)


def linear(colours):
    """Linear RGB (n, 3) of colours, names or numbers."""
    srgb = np.array([to_rgb(colour) for colour in colours])
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def seen(colours, vision):
    """CIELAB (n, 3) of colours with a kind of vision."""
    rgb = np.clip(linear(colours) @ VISIONS[vision].T, 0, 1)
    share = rgb @ _XYZ.T / _WHITE
    f = np.where(share > 216 / 24389, np.cbrt(share), (24389 / 27 * share + 16) / 116)
    x, y, z = f.T
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=1)


def least_difference(first, other):
    """How far two colours are apart for whom they are least."""
    pairs = (seen([first, other], vision) for vision in VISIONS)
    return min(float(np.linalg.norm(a - b)) for a, b in pairs)


def contrast(first, other):
    """From 1 to 21."""
    dark, light = sorted(linear([first, other]) @ _XYZ[1])
    return float((light + 0.05) / (dark + 0.05))


def lightness_is_ordered(colours, vision, slack=0.5):
    """Whether lightness rises or falls throughout, or has one turn, in the middle."""
    steps = np.diff(seen(colours, vision)[:, 0])
    half = len(steps) // 2
    parts = (steps,), (steps[:half], -steps[half:])
    return any(
        all((sign * part > -slack).all() for part in several)
        for several in parts
        for sign in (1, -1)
    )


def palette_figure():
    """Curves and areas of the palette, as they are and as they are seen without a kind of cones."""
    from matplotlib.colors import to_hex
    from matplotlib.figure import Figure

    from compare.figures import style

    curves = ["BLUE", "VERMILLION", "GREEN", "PURPLE", "BROWN", "VIOLET", "BLACK"]
    areas = ["SKY", "ORANGE", "YELLOW"]
    figure = Figure(figsize=(8, 2.6), layout="constrained")
    panel = figure.subplots()
    for row, (vision, matrix) in enumerate(VISIONS.items()):
        for column, name in enumerate([*curves, *areas]):
            rgb = np.clip(linear([getattr(style, name)])[0] @ matrix.T, 0, 1)
            srgb = np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * rgb ** (1 / 2.4) - 0.055)
            panel.barh(row, 0.94, 0.8, column, align="center", color=to_hex(srgb))
            if row == 0:
                panel.text(column + 0.47, -0.55, name.lower(), ha="center", fontsize="small")
        panel.text(-0.1, row, vision, ha="right", va="center")
    panel.set(xlim=(-1.6, 10), ylim=(3.5, -0.9))
    panel.axis("off")
    return figure


if __name__ == "__main__":
    palette_figure().savefig("docs/figures/palette.png", dpi=100)
