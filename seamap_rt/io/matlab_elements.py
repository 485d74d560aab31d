"""Elements of MATLAB's files of version 5 (MathWorks, MAT-File Format): whether SciPy may be given them.

Where an element is of no type, or a variable lacks one, SciPy 1.17 reads memory that is not its own, and may end the
process.
"""

from __future__ import annotations

import math
import os
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from .opening import bytes_held, check_declared_size

_MATRIX, _PACKED = 14, 15  # types of elements of MATLAB's files of version 5 that hold a variable, plainly or packed
_NUMBER_BYTES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8}  # by type of element
_WHOLE, _TEXT = (5, 6), (16, 17, 18)
_OF_VARIABLES, _CHARACTERS, _SPARSE, _NUMERIC, _OPAQUE = (1, 2, 3), 4, 5, range(6, 16), 17  # classes of variables
_OF_FIELDS = {2: 3, 3: 4}  # structs' class and objects': the element that tells how long the names of fields are
_MOST = 10**6  # variables in one, or blanks
_SHORT = 4096  # bytes of an element that is read here
_COMPLEX = 0x800  # flag of one


def check_version_5(opened: BinaryIO, path: Path) -> None:
    """Raise InputError for a file whose variables are too large, those of version 5 once they are unpacked, which is
    done piece by piece, since what they say of their length may be wrong; ValueError where a variable's elements are of
    no type that there is, or do not hold what it says: SciPy reads memory that is not its own then, or crashes."""
    held, mark = bytes_held(path), opened.read(128)[126:]
    total, order = float(os.fstat(opened.fileno()).st_size), "<" if mark == b"IM" else ">"
    check_declared_size(str(path), total, held)
    while mark in (b"IM", b"MI") and len(tag := opened.read(8)) == 8:
        kind, size = struct.unpack(f"{order}II", tag)
        after = opened.tell() + size

        def unpacked(left: int = size) -> Iterator[bytes]:
            nonlocal total
            unpack = zlib.decompressobj()
            while left and (piece := opened.read(min(left, 1 << 20))):
                left -= len(piece)
                while piece:
                    whole = unpack.decompress(piece, 1 << 20)
                    total += len(whole)
                    check_declared_size(str(path), total, held)
                    yield whole
                    piece = unpack.unconsumed_tail

        def plain(left: int = size) -> Iterator[bytes]:
            while left and (piece := opened.read(min(left, 1 << 20))):
                left -= len(piece)
                yield piece

        stream = _Stream(unpacked() if kind == _PACKED else plain())
        if kind == _PACKED:
            kind, size = struct.unpack(f"{order}II", stream.take(8))
        if kind == _MATRIX:
            _check_variable(stream, size, order)
        stream.skip(None)
        opened.seek(after)
    opened.seek(0)


class _Stream:
    """Bytes that come in pieces."""

    def __init__(self, pieces: Iterator[bytes]) -> None:
        self._pieces, self._held = pieces, b""

    def take(self, count: int) -> bytes:
        """The next bytes; fewer at the end."""
        while len(self._held) < count and (piece := next(self._pieces, None)) is not None:
            self._held += piece
        taken, self._held = self._held[:count], self._held[count:]
        return taken

    def skip(self, count: int | None) -> None:
        """Leave bytes out; None: all."""
        while count is None or count > len(self._held):
            count = None if count is None else count - len(self._held)
            piece = next(self._pieces, None)
            self._held = piece or b""
            if piece is None:
                return
        self._held = self._held[count:]


def _check_variable(stream: _Stream, left: int, order: str) -> None:
    """Raise ValueError unless a variable's elements are what its class and dimensions say (MathWorks, MAT-File Format).

    left: bytes of it."""
    number = numbers = variable = parts = held = fields = 0
    length = 1  # of a field's name
    while left > 0:
        tag = stream.take(8)
        kind, size = struct.unpack(f"{order}II", tag) if len(tag) == 8 else (0, 0)
        small = kind >> 16
        kind, size = (kind & 0xFFFF, small) if small else (kind, size)
        padded = 0 if small else min(-(-size // 8) * 8, left - 8)
        left -= 8 + padded
        allowed = (_MATRIX,) if variable in _OF_VARIABLES else _TEXT if variable == _CHARACTERS else ()
        allowed += _TEXT if number == 2 else ()  # a name
        if small > 4 or size > padded + small or kind not in (*_NUMBER_BYTES, *allowed):
            raise ValueError(f"an element of type {kind} and {size} bytes")
        if kind == _MATRIX:
            held += 1
            _check_variable(stream, size, order)
            number += 1
            continue
        short = size <= _SHORT
        content = tag[4 : 4 + size] if small else stream.take(padded)[:size] if short else stream.skip(padded) or b""
        count = size // 4 if short else 0
        whole = struct.unpack(f"{order}{count}i", content[: 4 * count])
        if number == 0:
            if (kind, size) != (6, 8) or not 0 < whole[0] & 0xFF <= _OPAQUE:
                raise ValueError("a variable of no class")
            variable, parts = whole[0] & 0xFF, 2 if whole[0] & _COMPLEX else 1
            if variable > _NUMERIC[-1]:  # a function or an object of MATLAB's own: not read
                stream.skip(left)
                return
        elif number == 1:
            if kind not in _WHOLE or size % 4 or not whole or min(whole) < 0:
                raise ValueError("a variable without dimensions")
            numbers = math.prod(whole)
        elif variable in _OF_FIELDS and number == _OF_FIELDS[variable]:
            length = whole[0] if kind in _WHOLE and size == 4 else 0
            if length <= 0:
                raise ValueError("a struct whose fields have no names")
        elif variable in _OF_FIELDS and number == _OF_FIELDS[variable] + 1:
            fields = size // length
        elif number > 2 and variable in _NUMERIC and size != numbers * _NUMBER_BYTES[kind]:
            raise ValueError(f"{size} bytes of type {kind} for {numbers} numbers")
        elif number > 2 and variable == _CHARACTERS and (size or numbers > _MOST) and size < numbers:
            raise ValueError(f"{size} bytes for {numbers} characters")
        number += 1
    wanted = numbers * (fields if variable in _OF_FIELDS else 1)
    if variable in _OF_VARIABLES:
        own = _OF_FIELDS[variable] + 2 if variable in _OF_FIELDS else 3
        right = number == own + held and held == wanted and numbers <= _MOST
    else:
        right = number == {_CHARACTERS: 4, _SPARSE: 5 + parts}.get(variable, 3 + parts if variable else 0)
    if not right:
        raise ValueError("a variable that lacks an element, or has one too many")
