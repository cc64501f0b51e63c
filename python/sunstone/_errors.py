"""The errors of the package. Their text is the library's own."""

from __future__ import annotations


class Error(Exception):
    """Whatever Sunstone refuses, but for files: what the system says of these is an OSError."""


class SceneError(Error, ValueError):
    """Something in a scene is missing, invalid or not physical.

    The text names the file, the object and its field, and says how to mend it.
    """


class RenderError(Error):
    """A render cannot begin: an option is out of its range, or the memory too small."""


class SceneWarning(UserWarning):
    """Something in a scene is not rendered as it was described."""


class RenderWarning(UserWarning):
    """There is something to doubt about an image."""


for _class in (Error, SceneError, RenderError, SceneWarning, RenderWarning):
    _class.__module__ = "sunstone"
