"""What was changed of marks, dates and rights in a class: who, when, what, before and after."""
