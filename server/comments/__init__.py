"""What is said of work: comments and questions in threads, phrases kept for later, a word to several students."""
