"""Groups of settings and results, a file for each panel or so; `properties.py` points to them."""
