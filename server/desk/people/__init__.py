"""Who is in a class: making it, joining it, its list, its settings."""
