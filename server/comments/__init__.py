"""Comments on work: threads of messages, kept phrases, notes to several students. See README.md in this folder."""
