"""The objectives of a class: its page, each student's, the sheet for the conseil de classe, the file of mistakes."""
