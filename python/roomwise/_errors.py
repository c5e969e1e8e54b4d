"""How Roomwise says that something failed."""

import enum


class ErrorCode(enum.Enum):
    """What a program decides by where something failed."""

    FAILED = "failed"  # nothing in particular
    INTERRUPTED = "interrupted"  # somebody asked to stop; what was done till then is kept
    REFUSED = "refused"  # the other side lets nobody in: trying the same again is no use
    DISK_FULL = "disk full"  # there is no room to write; what was written before is kept
    DAMAGED = "damaged"  # what was stored is not what was written


class Error(Exception):
    """Something that can fail in normal use failed.

    Its text names the file, line, frame or field that is wrong, and how to mend it; `code` is for
    programs. (Arguments of a wrong type or shape are a TypeError or a ValueError.)
    """

    def __init__(self, message: str, code: ErrorCode = ErrorCode.FAILED) -> None:
        super().__init__(message)
        self.code = code


# Users know them by the package.
for _type in ErrorCode, Error:
    _type.__module__ = "roomwise"
