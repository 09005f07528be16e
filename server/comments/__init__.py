"""What is said of work: threads of messages, kept phrases, words to several students. See README.md in this folder."""
