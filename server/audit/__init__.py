"""The audit log of a class: every change of marks, dates and rights, with its author."""
