"""Code inside the walls: the template process and its forks. It needs the standard library and numpy only, so that a
bare ``python -I -S`` can load it as the package ``child``; `codec` and `frames` also serve the trusted side."""
