"""Damage by a seeded generator: to bytes, to text, and to trees of tables, lists and values."""

from __future__ import annotations

import copy
import json
import random
import re
from typing import Any

EXTREMES: tuple[Any, ...] = (
    0, -1, 1, 2, 3, 1e-300, -1e-300, 5e-324, 1e308, -1e308, 1e30, -1e30, 1e9, 2**31, 2**63 - 1, -(2**63), 2**64, 0.5,
    -0.5, 1e-6, 1e3, 90.0, 180.0, 360.0, 720.0, -999.0, -99.0, 9.969209968386869e36, float("nan"), float("inf"),
    float("-inf"), True, False, None, "", "x", "nan", "1e999", "\x1b[31m", "ü\x85\u202e", "a" * 5000, "/", "../..",
    "\0", [], [1], [1, 2, 3], [[]], {}, {"a": 1}, [{}],
)  # fmt: skip
_TOKENS = (
    b"0", b"-1", b"1e308", b"-1e308", b"1e-320", b"nan", b"inf", b"-inf", b"999999999999999999999", b"-999", b"true",
    b"\"\"", b"[]", b"{}", b"\xff\xfe", b"\x00", b"\x1b[2J", b"\xe4", b",,,,", b"\n\n", b"\r", b"\t", b"'", b"#",
    b"=", b"[[", b"]]", b"9" * 400, b"a" * 6000,
)  # fmt: skip
_NUMBER = re.compile(rb"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")


def damaged_bytes(content: bytes, dice: random.Random) -> bytes:
    """Bytes flipped, cut, inserted, doubled or exchanged, once or a few times."""
    data = bytearray(content)
    for _ in range(dice.choice((1, 1, 1, 2, 4))):
        _damage(data, dice)
    return bytes(data)


def _damage(data: bytearray, dice: random.Random) -> None:
    size = len(data)
    at, other = (dice.randrange(size + 1) for _ in range(2))
    first, last = sorted((at, min(other, at + dice.choice((1, 4, 64, size + 1)))))
    match dice.randrange(9):
        case 0 | 1 if size:
            for _ in range(dice.choice((1, 1, 3, 16))):
                data[dice.randrange(size)] ^= 1 << dice.randrange(8)
        case 2:
            del data[at:]
        case 3:
            del data[first:last]
        case 4:
            data[at:at] = data[first:last]
        case 5:
            data[first:last] = bytes((dice.choice((0, 255, 0x7F)),)) * (last - first)
        case 6:
            data[at:at] = dice.choice(_TOKENS)
        case 7:
            data[at:at] = dice.randbytes(dice.choice((1, 8, 100)))
        case _:
            numbers = list(_NUMBER.finditer(bytes(data[:200_000])))
            if numbers:
                chosen = dice.choice(numbers)
                data[chosen.start() : chosen.end()] = dice.choice(_TOKENS)


def damaged_tree(tree: dict[str, Any], dice: random.Random) -> dict[str, Any]:
    """A copy in which values, keys or branches are exchanged, lost or moved."""
    result = copy.deepcopy(tree)
    for _ in range(dice.choice((1, 1, 1, 2, 3))):
        holders = list(_holders(result))
        if not holders:  # all of it is lost already
            break
        holder, key = dice.choice(holders)
        value = holder[key]
        match dice.randrange(10):
            case 0:
                del holder[key]
            case 1 if isinstance(holder, dict):
                holder[dice.choice((key + "s", key[:-1], key.upper(), "x" * 3000, "\x1b", ""))] = holder.pop(key)
            case 2:
                other, there = dice.choice(holders)
                other[there] = copy.deepcopy(value)
            case 3 if isinstance(value, int | float) and not isinstance(value, bool):
                holder[key] = value * dice.choice((-1, 0, 10, 0.1, 1e3, 1e-3, 1e30, 1 + 1e-9))
            case 4 if isinstance(value, list):
                holder[key] = value * dice.choice((0, 2, 50))
            case 5:
                holder[key] = [value] if dice.random() < 0.5 else {"x": value}
            case 6:
                holder[key] = str(value)
            case _:
                holder[key] = copy.deepcopy(dice.choice(EXTREMES))
    return result


def _holders(tree: Any) -> list[tuple[Any, Any]]:
    """Each table or list, and each key of it."""
    inside = list(tree.items()) if isinstance(tree, dict) else list(enumerate(tree)) if isinstance(tree, list) else []
    return [(tree, key) for key, _ in inside] + [each for _, value in inside for each in _holders(value)]


def toml_of(tree: dict[str, Any], prefix: str = "") -> str:
    """A tree as TOML; what TOML has not, as nothing."""
    plain = {key: value for key, value in tree.items() if not _is_section(value)}
    text = "".join(f"{json.dumps(key)} = {_inline(value)}\n" for key, value in plain.items() if value is not None)
    for key, value in tree.items():
        if _is_section(value):
            name = f"{prefix}{json.dumps(key)}"
            for each in value if isinstance(value, list) else [value]:
                text += ("\n[[{}]]\n" if isinstance(value, list) else "\n[{}]\n").format(name)
                text += toml_of(each, f"{name}.")
    return text


def _is_section(value: Any) -> bool:
    sections = value if isinstance(value, list) else [value]
    return bool(sections) and all(isinstance(each, dict) for each in sections)


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)} = {_inline(v)}" for k, v in value.items() if v is not None) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_inline(each) for each in value if each is not None) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value)
