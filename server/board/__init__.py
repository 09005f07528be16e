"""The live board of a class: who is where, what is misunderstood, what has helped. See README.md in this folder."""
