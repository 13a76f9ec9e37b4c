"""tendril's results in Python: reading, drawing, playing them."""

from .results import Results, ResultsError, Shape, load

__all__ = ["Results", "ResultsError", "Shape", "load"]
