"""The one place that imports colour-science: its notice that SciPy is absent is not the user's business.

Nothing we call there needs SciPy.
"""

from __future__ import annotations

import warnings

with warnings.catch_warnings():
    warnings.filterwarnings("ignore", message=r".*related API features are not available.*")
    import colour

__all__ = ["colour"]
