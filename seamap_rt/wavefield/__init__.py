"""What the maps say of the waves: spectrum, direction, sea state, and where the waves run from one moment to another.

Reads maps alone. The retrieval's last step, a ground map at one moment, uses it too.
"""

from .sea_state import in_words, sea_state

__all__ = ["in_words", "sea_state"]
