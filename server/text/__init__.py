"""The course's Markdown as HTML: blocks, numbers, links, mathematics, coloured code."""
