"""USD's errors in words for users."""

from pxr import Tf

__all__ = ["describe_error"]


def describe_error(error: Exception) -> str:
    """Give what an error says in one line, without USD's source file, line and function.

    Parameters
    ----------
    error
        Usually a ``Tf.ErrorException``, which carries one or more errors.
    """
    said = [part.commentary if isinstance(part, Tf.Error) else str(part) for part in error.args]
    lines = [" ".join(text.split()) for text in said] if isinstance(error, Tf.ErrorException) else [str(error)]
    return "; ".join(dict.fromkeys(lines))
