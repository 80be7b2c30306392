"""All that is wrong with the arguments of a call, said at once."""

from __future__ import annotations

from types import TracebackType

KINDS = (KeyError, TypeError, ValueError)
"""What wrong arguments are refused with."""


class Faults:
    """Collects refusals of one call, each a sentence that names its argument."""

    def __init__(self) -> None:
        self._found: list[Exception] = []

    def __bool__(self) -> bool:
        return bool(self._found)

    def note(self, refusal: Exception) -> None:
        """Note one."""
        self._found.append(refusal)

    def add(self, sentence: str) -> None:
        """Note a ``ValueError`` that says this."""
        self.note(ValueError(sentence))

    def collecting(self) -> Faults:
        """What is refused inside ``with faults.collecting():`` is noted; the rest of the block is left out."""
        return self  # no generator: short runs enter ten of these blocks

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> bool:
        if not isinstance(error, KINDS):
            return False
        self._found.append(error)
        return True

    def stop_if_any(self) -> None:
        """Raise the one that was noted, or one with the sentences of all, a line for each.

        That is of their kind where all are of one, else a ``ValueError``.
        """
        if len(self._found) == 1:
            raise self._found[0]
        if self._found:
            lines = dict.fromkeys(line for error in self._found for line in sentence(error).splitlines())
            kinds = {type(error) for error in self._found}
            kind = kinds.pop() if len(kinds) == 1 else ValueError
            raise (kind if kind in (TypeError, UnknownName) else ValueError)("\n".join(lines))


def sentence(error: Exception) -> str:
    """What an error says; ``str`` of a ``KeyError`` is that in quotation marks."""
    return str(error.args[0]) if isinstance(error, KeyError) and error.args else str(error)


class UnknownName(KeyError):
    """A name that is not there; its text reads as a sentence, not as a key in quotation marks."""

    def __str__(self) -> str:
        return sentence(self)
