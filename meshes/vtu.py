"""Meshes with fields as VTU files: unstructured grids of VTK in XML, compressed with zlib."""

from __future__ import annotations

import math
import zlib
from base64 import b64decode, b64encode
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.arrays import Array

KINDS = {3: 5, 4: 9}
"""VTK's numbers of triangles and quadrilaterals, by their corners."""
POINTS, CELLS = "Points", "connectivity"
"""Names of the arrays of nodes, and of the nodes of the elements one after the other."""
BLOCK = 2**15
"""Bytes that are compressed together."""
LEVEL = 1
"""Level of compression.  On a frame of 190,000 nodes the default level, 6, takes 3.4 times as long
and saves 3 %."""
_compressed = lru_cache(maxsize=1024)(partial(zlib.compress, level=LEVEL))
"""Blocks of bytes, compressed; those of the mesh come again in each frame."""


@dataclass(frozen=True, eq=False)
class FieldMesh:
    """A mesh of triangles or quadrilaterals with fields."""

    points: Array  # (n, 3) array: nodes [length]
    cells: NDArray[np.integer[Any]]  # (m, k) array: nodes of each element
    point_data: Mapping[str, NDArray[np.floating[Any]]]  # (n, 3) arrays at the nodes, by name
    cell_data: Mapping[str, NDArray[np.floating[Any]]]  # (m,) arrays in the elements, by name

    def parts(self) -> Iterator[bytes]:
        """Yield the text of a file, part by part."""
        count, corners = self.cells.shape
        offsets = np.arange(corners, corners * count + 1, corners, dtype=self.cells.dtype)
        types = np.full(count, KINDS[corners], dtype=np.int8)
        sections: Mapping[str, Mapping[str, NDArray[Any]]] = {
            "Points": {POINTS: self.points},
            "Cells": {CELLS: self.cells.ravel(), "offsets": offsets, "types": types},
            "PointData": self.point_data,
            "CellData": self.cell_data,
        }
        yield (
            b'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="0.1" '
            b'byte_order="LittleEndian" compressor="vtkZLibDataCompressor">\n<UnstructuredGrid>\n'
            b'<Piece NumberOfPoints="%d" NumberOfCells="%d">\n' % (len(self.points), count)
        )
        for section, arrays in sections.items():
            yield f"<{section}>\n".encode()
            for name, values in arrays.items():
                head = f'type="{values.dtype.name.title()}" Name="{name}" format="binary"'
                head += f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
                yield f"<DataArray {head}>\n".encode() + array_text(values) + b"\n</DataArray>\n"
            yield f"</{section}>\n".encode()
        yield b"</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"


def array_text(values: NDArray[Any]) -> bytes:
    """Return an array as the text in a file: sizes of its blocks, and the blocks, compressed."""
    raw = values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()
    blocks = [_compressed(raw[at : at + BLOCK]) for at in range(0, len(raw), BLOCK)]
    sizes = [len(blocks), BLOCK, len(raw) % BLOCK, *map(len, blocks)]
    return b64encode(np.array(sizes, dtype="<u4").tobytes()) + b64encode(b"".join(blocks))


def array_in(entry: ElementTree.Element) -> NDArray[Any]:
    """Return the array that an element of a file holds: (n,), or (n, k) of k > 1 components."""
    text = (entry.text or "").strip()
    count = int.from_bytes(b64decode(text[:8])[:4], "little")
    end = 4 * math.ceil(4 * (3 + count) / 3)  # four characters stand for three bytes
    sizes = np.frombuffer(b64decode(text[:end]), "<u4")[3:]
    blocks, ends = b64decode(text[end:]), np.cumsum(sizes, dtype=int)
    raw = b"".join(zlib.decompress(blocks[at - n : at]) for at, n in zip(ends, sizes, strict=True))
    values = np.frombuffer(raw, np.dtype(entry.attrib["type"].lower()).newbyteorder("<"))
    width = int(entry.get("NumberOfComponents", 1))
    return values.reshape(-1, width) if width > 1 else values
