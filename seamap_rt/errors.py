"""What can be refused: every error that a user of the package may meet, each said in one line."""

from __future__ import annotations


class InputError(ValueError):
    """Bad input, said in exactly one line."""

    def __init__(self, message: str) -> None:
        super().__init__(" ".join(message.split()))


class SchemaError(ValueError):
    """A dataset that does not keep the schema; the message is one line."""


class NoBackend(RuntimeError):
    """Nothing here can run Dr.Jit. The message is one line and names the command that mends it."""
