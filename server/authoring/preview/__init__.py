"""A course as it is written: its pages, reloaded at each change, its faults, and its exercises tried at a click.

`supervising` keeps the address and forks a process for each version of the files, so that each imports the author's
code anew; `serving` is that process, `watching` sees the changes, `faults` looks for what is wrong.
"""
