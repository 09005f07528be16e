"""The live board of a class: progress, misconceptions and statistics. See README.md in this folder."""
