"""What all commands share: the application, KEY=VALUE pairs, and the scene they name."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import wraps
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter, Token
from rich.console import Console

from .. import __version__
from ..compute.machine import A_MODEL, A_RUN, Need, check_memory
from ..errors import InputError, say_of
from ..io.text import parse_number

if TYPE_CHECKING:
    from ..io.stream import Broadcast

app = App(
    name="seamap-rt",
    version=__version__,
    help="What an interferometric radar on a small boat's mast can see of the sea around it.",
    help_format="plaintext",
    suppress_keyboard_interrupt=False,  # `main` says what an interrupted run leaves
)


def about(text: str) -> Parameter:
    """What --help says of an option, where it fits into its line; longer words stand in the docstring."""
    return Parameter(help=text)


Names = Annotated[list[str], Parameter(name="--name", negative=(), consume_multiple=False)]


def _number(kind: Callable[[str], Any], wanted: str) -> Parameter:
    """An option's number, whose refusal says what is wanted."""

    def convert(_: Any, tokens: Sequence[Token]) -> Any:
        try:
            parse_number(tokens[0].value)
            return kind(tokens[0].value)
        except ValueError:
            raise ValueError(f"{tokens[0].value} must be {wanted}") from None

    return Parameter(converter=convert)


Count = Annotated[int, _number(int, "a whole number, 1 or more")]  # cyclopts itself would take 1.5 as 1
Whole = Annotated[int, _number(int, "a whole number, 0 or more")]
Number = Annotated[float, _number(float, "a number")]


def command(
    *examples: str, name: str | None = None, need: Need = A_RUN
) -> Callable[[Callable[..., int]], Callable[..., int]]:
    """Join a function to the application; its --help ends with the examples. need: the least that it takes, without
    which nothing of it is loaded: libraries wait for ever for memory, or end the process."""
    ending = "\n".join(["Examples:", *(f"  seamap-rt {each}" for each in examples)])

    def join(function: Callable[..., int]) -> Callable[..., int]:
        @wraps(function)
        def checked(*words: Any, **options: Any) -> int:
            check_memory(f"seamap-rt {examples[0].split()[0]}", need)
            if need is not A_MODEL:
                gc.freeze()  # what is loaded stays; and a compiler makes objects by ten thousands
                gc.set_threshold(10_000)
                gc.enable()
            return function(*words, **options)

        app.command(checked, name=name, help_epilogue=ending)
        return function

    return join


Settings = Annotated[list[str], Parameter(name="--set", negative=(), consume_multiple=False)]
SceneName = Annotated[str, about("Path of a scene file, or the name of a shipped scene.")]
Turns = Annotated[Count | None, about("Turns of the antenna.")]
Seed = Annotated[Whole | None, about("Of all random numbers.")]
Tracer = Annotated[str | None, about("facets, horizon or paths.")]
StreamTo = Annotated[str | None, about("tcp://HOST:PORT: a line of JSON for each turn to all who connect there.")]
StreamFormat = Annotated[Literal["json", "signalk"] | None, about("Of the lines: json (default) or signalk deltas.")]
Overwrite = Annotated[bool, about("Replace earlier results in that folder.")]
_ANY_KEY = "KEY=VALUE, any key of the scene file"
SceneKeys = Annotated[Settings | None, Parameter(help=f"{_ANY_KEY}, as often as wanted.")]
KeysOfHorizon = Annotated[
    Settings | None,
    Parameter(help=f"{_ANY_KEY}. Shadows are found by the horizon; tracing.tracer=facets traces rays."),
]
errors = Console(stderr=True, soft_wrap=True, highlight=False, markup=False)
console = Console(soft_wrap=True, highlight=False, markup=False)  # a path may hold [brackets]


def overrides_of(pairs: list[str] | None, option: str = "--set", **direct: Any) -> dict[str, Any]:
    """KEY=VALUE strings, and options that stand for a key, as one mapping."""
    overrides: dict[str, Any] = {}
    for pair in pairs or []:
        key, equals, value = pair.partition("=")
        if not equals or not key.strip():
            raise InputError(f"{option} {pair}: must be KEY=VALUE, as in --set radar.height_m=10")
        overrides[key.strip()] = value.strip()
    return overrides | {key: value for key, value in direct.items() if value is not None}


def section_of(model: Any, name: str, command: str, pairs: list[str] | None, **direct: Any) -> Any:
    """Settings of the one section that a command takes, from its --set pairs and options that stand for a key."""
    from ..io.scenefile import apply_overrides
    from ..io.validation import validate

    overrides = overrides_of(pairs)
    for key in overrides:
        if not key.startswith(f"{name}."):
            example = next(iter(model.model_fields))
            raise InputError(
                f"--set {key}: {command} takes only {name}.KEY, as in --set {name}.{example}="
                f"{model.model_fields[example].default}"
            )
    tree = apply_overrides({}, {key.removeprefix(f"{name}."): value for key, value in overrides.items()})
    with say_of(f"{name}.", InputError):
        return validate(model, direct | tree)


def scene_of(name: str, pairs: list[str] | None, **direct: Any):
    from ..scene import load_scene

    return load_scene(name, overrides=overrides_of(pairs, **{k.replace("__", "."): v for k, v in direct.items()}))


@contextmanager
def streaming(address: str | None, form: str | None) -> Iterator[Broadcast | None]:
    """Who listens at an address, if one is given; beyond this machine that is said."""
    if address is None:
        if form is not None:
            raise InputError(f"--stream-format {form}: needs --stream; give both or neither")
        yield None
        return
    from ..io.stream import Broadcast

    with Broadcast(address) as broadcast:
        console.print(f"stream: {broadcast.address}")
        if not broadcast.loopback:
            errors.print("warning: --stream: everyone who reaches this machine can read the stream; nothing guards it")
        yield broadcast
